// The printing stage: the placed drawing in, the pre-distorted print in sheet coordinates out: lines where the drawing has
// them, pixels where it has not.
//
// The pixel grid is centred on the sheet's centre: with pixels of d = 25.4 / dpi mm, width W = ceil(sheet
// width / d) and height H likewise, the centre of pixel (i, j) (column, row from the top) lies at
//   s = (i + 0.5 - W / 2) d,  t = (H / 2 - j - 0.5) d,
// and at -s when the print is mirrored. The top row is the back of the sheet (+t).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/pattern/pattern.hpp"
#include "worker/placement/placement.hpp"
#include "worker/printing/vector_print.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct Print {
  // Parallel to Flattening::triangles: pattern coordinates of the corners, mm, as the placement's charts have them.
  // Triangles that share a vertex differ there across a seam alone.
  std::vector<std::array<Eigen::Vector2d, 3>> pattern_uv;
  // Of each of the placement's seams: how far its two sides lie apart on the flat sheet, at most, mm.
  std::vector<double> seam_gap_mm;
  // The whole sheet, exact dpi in pHYs, mirrored when the inner face is inked. A grayscale drawing gives
  // 8-bit gray on white, another 8-bit RGB on white, or RGBA where settings.print.background is transparent. With marks where settings.print.marks asks for
  // them.
  std::vector<std::uint8_t> png;
  int width = 0, height = 0;  // pixels
  double pixel_mm = 0;
  // The same at 1:1: user units mm, origin the sheet's centre, x = s, y = -t. Layer "pattern", under scale(-1 1) when
  // mirrored, holds each element in a group with its id, painted outlines and unpainted centre lines of class
  // "centreline"; of a drawing without lines, the chart's part as an image. Layer "marks": vectors and text.
  std::string svg;
  // The same on a page of the sheet's size, vectors or an image embedded without loss, texts as texts, in two layers.
  std::vector<std::uint8_t> pdf;
  std::optional<VectorPrint> vectors;  // what the three are made of, where the drawing is one of vectors
  bool mirrored = false;
  double ink_area_mm2 = 0;  // of the drawing
  double ink_printed = 0;   // the fraction of it that lies on the chart or on its element's patch, in [0, 1]
  double ink_on_head = 0;   // the fraction of it that lies on the chart, and so on the mold, once formed
  // "ink-off-chart" (with the loss), "marks-left-out", "ink-not-compensated", and the pattern's own
  std::vector<Warning> warnings;

  // Where on the picture sheet coordinates lie, as a fraction of its width from the left and its height from
  // below.
  Eigen::Vector2d picture_uv(const Eigen::Vector2d& st) const {
    return {0.5 + (mirrored ? -st.x() : st.x()) / (width * pixel_mm), 0.5 + st.y() / (height * pixel_mm)};
  }
};

// `drawing` is what read_drawing() made of the pattern's file, null where that is a picture; `placement` is what place()
// made of it, or of the drawing of parts_to_place(): each part of a picture is then printed through its own patch. Lines are pulled back as vectors and drawn anti-aliased. Of a picture every pixel is the mean of 4 to 16
// samples, each filtered by the footprint that its triangle gives it, so that edges are smooth, also the chart's own.
// With settings.print.compensate_ink, shades of gray are printed darker where the sheet stretches more (see
// ink_compensation.hpp). Memory is that of the files made plus a band of rows, whatever the dpi. `label` is the readable
// name of the job on the print (the digest of its inputs, so that bytes repeat); what is not printable ASCII in it becomes
// '?'. Pure and deterministic, whatever the number of threads.
// Errors: cancelled; unusable_pattern (no ink falls onto the chart); too_large (more than 32,000 pixels a side).
Result<Print> make_print(const ChartedSurface& charted, const Pattern& pattern, const Drawing* drawing,
                         const Placement& placement, const Settings& settings, const std::string& label,
                         const Context& context);

}  // namespace vacuform
