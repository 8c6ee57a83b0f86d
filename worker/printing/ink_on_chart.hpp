// How much of a drawing falls onto the charts. Internal to worker/printing.
#pragma once

#include "worker/printing/print.hpp"

namespace vacuform {

// The fraction of the ink of the drawing inside the triangles of the charts in pattern coordinates, in [0, 1], measured
// on a grid of a thousand cells along the longer side of the drawing.
double ink_on_chart(const std::vector<std::array<Eigen::Vector2d, 3>>& pattern_uv, const Pattern& pattern);

}  // namespace vacuform
