// The printing stage: takes the placed drawing and makes the pre-distorted print in sheet coordinates, with lines where
// the drawing has lines, and pixels elsewhere.
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
#include "worker/printing/output_profile.hpp"
#include "worker/printing/print_label.hpp"
#include "worker/printing/vector_print.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

class SheetColours;  // worker/colour

// Where full ink cannot show the colours of a scan, because the sheet stretches (worker/printing/colour_ink.hpp).
struct InkShortage {
  double coloured_mm2 = 0;  // of the formed inked face
  double short_mm2 = 0;     // of that, where more than 1 % coverage of an ink is missing
  double lack = 0;          // the largest, coverage
  std::size_t ink = 0;      // of which: ink_names
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the largest, mm

  double share() const { return coloured_mm2 > 0 ? short_mm2 / coloured_mm2 : 0; }
};

struct Print {
  // Parallel to Flattening::triangles: pattern coordinates of the corners, mm, from the charts of the placement.
  // Triangles that share a vertex have different coordinates there only across a seam.
  std::vector<std::array<Eigen::Vector2d, 3>> pattern_uv;
  // For each seam of the placement: the largest distance between its two sides on the flat sheet, mm.
  std::vector<double> seam_gap_mm;
  // The whole sheet, exact dpi in pHYs, mirrored if the inner face is inked. A grayscale drawing gives 8-bit gray on
  // white, any other 8-bit RGB on white, or RGBA if settings.print.background is transparent. With marks if
  // settings.print.marks is set.
  std::vector<std::uint8_t> png;
  int width = 0, height = 0;  // pixels
  double pixel_mm = 0;
  // The same at 1:1: user units mm, origin the centre of the sheet, x = s, y = -t. Layer "pattern", under scale(-1 1)
  // if mirrored, holds each element in a group with its id, painted outlines and unpainted centre lines of class
  // "centreline"; for a drawing without lines, the part on the chart as an image. Layer "marks": vectors and text.
  std::string svg;
  // The same on a page of the size of the sheet, vectors or a losslessly embedded image, texts as texts, in two layers.
  std::vector<std::uint8_t> pdf;
  // With pattern.source=both: the colours of the scan in three separate files, on the same grid and page and with the
  // same marks.
  struct Layer {
    std::vector<std::uint8_t> png;
    std::string svg;
    std::vector<std::uint8_t> pdf;
  };
  std::optional<Layer> colours;
  std::optional<InkShortage> shortage;  // of the colours of the scan, if their ink is compensated
  std::optional<VectorPrint> vectors;   // the source of the three files, for a vector drawing
  OutputProfile profile;                // of the colours in the files
  bool mirrored = false;
  std::optional<double> ruler_mm;  // length of the printed ruler; none without marks or without room for it
  double ink_area_mm2 = 0;         // of the drawing
  double ink_printed = 0;  // the fraction of it that lies on the chart or on its element's patch, in [0, 1]
  double ink_on_head = 0;  // the fraction of it that lies on the chart, and so on the mold, once formed
  // "ink-off-chart" (with the loss), "marks-left-out", "ink-not-compensated", "ink-not-enough", and the pattern's own
  std::vector<Warning> warnings;

  // The position of sheet coordinates on the picture, as a fraction of its width from the left and its height from
  // below.
  Eigen::Vector2d picture_uv(const Eigen::Vector2d& st) const {
    return {0.5 + (mirrored ? -st.x() : st.x()) / (width * pixel_mm), 0.5 + st.y() / (height * pixel_mm)};
  }
};

// `drawing` is the result of read_drawing() for the file of the pattern, null for a picture. `placement` is the result
// of place() for it, or for the drawing of parts_to_place(): each part of a picture is then printed through its own
// patch. Lines are pulled back as vectors and drawn anti-aliased. For a picture every pixel is the mean of 4 to 16
// samples, each filtered by the footprint that its triangle gives it, so that edges are smooth, including those of the
// chart. With settings.print.compensate_ink, shades of gray are printed darker where the sheet stretches more (see
// ink_compensation.hpp). Memory is that of the resulting files plus a band of rows, for any dpi. `label` is the name of
// the job on the print (the digest of its inputs, so that bytes repeat) and its reference. The fonts of the print show
// Latin-1: other characters become '?', with the warning "reference-incomplete" for those of the reference. Pure and
// deterministic for any number of threads. Errors: cancelled; unusable_pattern (no ink falls onto the chart); too_large
// (more than 32,000 pixels per side).
//
// With `colours` and pattern.source=scan, the print shows the colours of the scan. `pattern` is then the result of
// picture_of() for them, `placement` that of lay_flat(), and there is no drawing. All of the ink counts as printed.
// Coverages are compensated for the stretch of the sheet, if settings.print.compensate_colours is set.
// PNG and PDF are marked as sRGB. With a `profile`, pixels that have colours are converted to it and marked as its own;
// vectors in PDF and SVG, marks, and shades of gray are not.
//
// With pattern.source=both, the colours become Print::colours and the print stays that of the drawing; marks keep clear
// of both.
Result<Print> make_print(const ChartedSurface& charted, const Pattern& pattern, const Drawing* drawing,
                         const Placement& placement, const Settings& settings, const PrintLabel& label,
                         const Context& context, const SheetColours* colours = nullptr,
                         const OutputProfile& profile = {});

// The colours of a scan as a picture of the flat sheet in sheet coordinates, for code that shows a drawing: 0.2 mm a
// pixel, or 4000 pixels on the longer side if that is coarser. Errors: cancelled.
Result<Pattern> picture_of(const SheetColours& colours, const SheetSettings& sheet, const Context& context);

}  // namespace vacuform
