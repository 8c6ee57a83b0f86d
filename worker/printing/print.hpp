// The printing stage: the flattening and the drawing in, the pre-distorted print in sheet coordinates out.
//
// The pixel grid is centred on the sheet's centre: with pixels of d = 25.4 / dpi mm, width W = ceil(sheet
// width / d) and height H likewise, the centre of pixel (i, j) (column, row from the top) lies at
//   s = (i + 0.5 - W / 2) d,  t = (H / 2 - j - 0.5) d,
// and at -s when the print is mirrored. The top row is the back of the sheet (+t).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/context.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/pattern/pattern.hpp"

namespace vacuform {

struct Print {
  // Per vertex of the sheet: pattern coordinates, mm, R(-rotate) (chart - offset) / scale; NaN off the chart.
  std::vector<Eigen::Vector2d> pattern_uv;
  // The whole sheet, exact dpi in pHYs, mirrored when the inner face is inked. A grayscale drawing gives
  // 8-bit gray on white, another 8-bit RGBA on transparent. With marks where settings.print.marks asks for
  // them.
  std::vector<std::uint8_t> png;
  int width = 0, height = 0;  // pixels
  double pixel_mm = 0;
  // The same at 1:1: user units mm, origin the sheet's centre, x = s, y = -t. Layer "pattern" holds the
  // chart's part as an image, under scale(-1 1) when mirrored; layer "marks" holds the marks as vectors and
  // text.
  std::string svg;
  bool mirrored = false;
  double ink_area_mm2 = 0;        // of the drawing
  double ink_printed = 0;         // the fraction of it that lies on the chart, in [0, 1]
  std::vector<Warning> warnings;  // "ink-off-chart" (with the loss), "marks-left-out", and the pattern's own

  // Where on the picture sheet coordinates lie, as a fraction of its width from the left and its height from
  // below.
  Eigen::Vector2d picture_uv(const Eigen::Vector2d& st) const {
    return {0.5 + (mirrored ? -st.x() : st.x()) / (width * pixel_mm), 0.5 + st.y() / (height * pixel_mm)};
  }
};

// Every pixel is the mean of 4 to 16 samples, each filtered by the footprint that its triangle gives it, so
// that edges are smooth, also the chart's own. Memory is that of the files made plus a band of rows, whatever
// the dpi. `label` is the readable name of the job on the print (the digest of its inputs, so that bytes
// repeat); what is not printable ASCII in it becomes '?'. Pure and deterministic, whatever the number of threads.
// Errors: cancelled; unusable_pattern (no ink falls onto the chart); too_large (more than 32,000 pixels a side).
Result<Print> make_print(const FormedSheet& sheet, const Flattening& flattening, const Pattern& pattern,
                         const Settings& settings, const std::string& label, const Context& context);

// Pattern coordinates of a point on the chart (or of anything laid on as the chart is), mm.
Eigen::Vector2d pattern_coordinates(const Eigen::Vector2d& chart, const PatternSettings& settings);

}  // namespace vacuform
