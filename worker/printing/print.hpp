// The printing stage: the flattening and the drawing in, the pre-distorted print at 1:1 in sheet coordinates out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/context.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/printing/pattern.hpp"

namespace vacuform {

struct Print {
  std::vector<Eigen::Vector2d> pattern_uv;  // per vertex of the sheet: pattern coordinates, mm; NaN off the chart
  std::vector<std::uint8_t> png;            // the whole sheet, exact dpi in pHYs, mirrored when the inner face is inked
  std::string svg;                          // the same at 1:1: user units mm, origin the sheet's centre, x = s, y = -t
  bool mirrored = false;
  double ink_area_mm2 = 0;                  // of the drawing
  double ink_printed = 0;                   // the fraction of it that lies on the chart, in [0, 1]
  std::vector<Warning> warnings;            // "ink-off-chart" with the fraction lost
};

// `label` is the readable name of the job on the print (the digest of its inputs, so that bytes repeat).
// Pure and deterministic. Errors: cancelled, unusable_pattern (no ink falls onto the chart).
Result<Print> make_print(const FormedSheet& sheet, const Flattening& flattening, const Pattern& pattern,
                         const Settings& settings, const std::string& label, const Context& context);

}  // namespace vacuform
