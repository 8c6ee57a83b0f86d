// The line on the flat sheet where the formed plastic leaves the mold. Internal to worker/printing.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/printing/laid_ink.hpp"
#include "worker/printing/marks.hpp"

namespace vacuform {

// The borders of the chart, given as closed rings in sheet coordinates, without the steps of a grid of `grid_mm`. The
// lines stop 2 mm from the ink, because they must not join the traces of the drawing. Sheet coordinates, dashed.
std::vector<Line> mold_outline(const std::vector<std::vector<Eigen::Vector2d>>& rings, double grid_mm,
                               const LaidInk& ink);

}  // namespace vacuform
