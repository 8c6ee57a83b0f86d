// What a person must know about a job that is not an error: it is in report.json, on the page and on the terminal.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/proposal.hpp"

namespace vacuform {

enum class Severity {
  note,     // nothing to do: what was chosen, or what cannot be better
  warning,  // look at the place before printing
  serious   // do not print before this is settled
};
constexpr std::string_view name(Severity severity) {
  constexpr std::array<std::string_view, 3> names{"note", "warning", "serious"};
  return names[static_cast<std::size_t>(severity)];
}

// One row for each code; docs/reference/warnings.md lists them all.
struct WarningKind {
  std::string_view code;  // stable, for machines: "undercut"
  Severity severity;
  std::string_view fix;  // what to do, if a warning has no fix
};
std::span<const WarningKind> warning_kinds();            // sorted by code
const WarningKind& warning_kind(std::string_view code);  // any other code is a bug, which ends the program

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
