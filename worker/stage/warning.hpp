// What a person must know about a job that is not an error: it is in report.json, on the page and on the terminal.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "api/base/proposal.hpp"
#include "api/warning_kinds.hpp"

namespace vacuform {

struct Warning {
  std::string code;
  std::string text;  // what is wrong, one sentence for people
  // Where and how large, for marks in a preview; several places of one warning, worst first, at most most_marks.
  static constexpr std::size_t most_marks = 20;
  struct Mark {
    std::array<double, 3> place_mm;  // in the mold's frame
    double size_mm = 0;              // across; 0: a point
  };
  std::vector<Mark> marks = {};
  // The measured value, and the limit that it passes.
  struct Figure {
    double value;
    std::string unit;  // "mm", "%", or empty for a ratio
    std::optional<double> limit = {};
  };
  std::optional<Figure> figure = {};
  std::string fix = {};                  // instead of its kind's
  std::string place = {};                // in words: "coil-3 and coil-4"; if it is empty, the marks show it
  std::vector<Proposal> proposals = {};  // settings that were tried and that settle it

  Severity severity() const { return warning_kind(code).severity; }
  std::string what_to_do() const;  // the fix, with the proposals as options of the command line
};

}  // namespace vacuform
