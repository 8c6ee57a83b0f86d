// The printing stage: takes the layers of what was placed (layer.hpp) and makes the pre-distorted print in sheet
// coordinates, with lines where a drawing has lines, and pixels elsewhere.
//
// The pixel grid is centred on the sheet's centre: with pixels of d = 25.4 / dpi mm, width W = ceil(sheet
// width / d) and height H likewise, the centre of pixel (i, j) (column, row from the top) lies at
//   s = (i + 0.5 - W / 2) d,  t = (H / 2 - j - 0.5) d,
// and at -s when the print is mirrored. The top row is the back of the sheet (+t).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/placement/charted_surface.hpp"
#include "worker/printing/layer.hpp"
#include "worker/printing/output_profile.hpp"
#include "worker/printing/print_label.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct Print {
  std::vector<Layer> layers;  // from the top; at least one
  PrintGrid grid;             // of the PNG files
  // Parallel to Flattening::triangles: pattern coordinates of the corners, mm, from the charts of the placement.
  // Triangles that share a vertex have different coordinates there only across a seam.
  std::vector<std::array<Eigen::Vector2d, 3>> pattern_uv;
  // For each seam of the placement: the largest distance between its two sides on the flat sheet, mm.
  std::vector<double> seam_gap_mm;
  OutputProfile profile;           // of the colours in the files
  std::optional<double> ruler_mm;  // length of the printed ruler; none without marks or without room for it
  // "ink-off-chart" (with the loss), "marks-left-out", "ink-not-compensated", "ink-not-enough", and those of the layers
  std::vector<Warning> warnings;

  // The layer whose files are called "print": what the pattern is, or its conductors; figures of ink are about it.
  const Layer& main() const;
  // The colours of a scan, if a layer prints them; otherwise null.
  const Layer* coloured() const;

  // The position of sheet coordinates on the picture of the main layer, as a fraction of its width from the left and its
  // height from below.
  Eigen::Vector2d picture_uv(const Eigen::Vector2d& st) const {
    return {0.5 + (main().mirrored() ? -st.x() : st.x()) / (grid.width * grid.pixel_mm),
            0.5 + st.y() / (grid.height * grid.pixel_mm)};
  }
};

struct PrintInputs {
  const ChartedSurface& charted;
  const Placement& placement;  // of what the main layer shows, on its face
  const Settings& settings;
  // The name of the job on the print (the digest of its inputs, so that bytes repeat) and its reference. The fonts of the
  // print show Latin-1: other characters become '?', with the warning "reference-incomplete" for those of the reference.
  PrintLabel label;
  std::vector<Layer> layers;  // without their files
  OutputProfile profile = {};
};

// Makes the files of all layers, on the same grid and page. Marks keep clear of all layers. Memory is that of the
// resulting files plus a band of rows, for any dpi. Pure and deterministic for any number of threads. Errors: cancelled;
// unusable_pattern (no ink of a layer falls onto the chart); too_large (more than 32,000 pixels per side).
//
// PNG and PDF with colours are marked as sRGB. With a profile, pixels that have colours are converted to it and marked as
// its own; vectors in PDF and SVG, marks, and shades of gray are not.
Result<Print> make_print(PrintInputs inputs, const Context& context);

}  // namespace vacuform
