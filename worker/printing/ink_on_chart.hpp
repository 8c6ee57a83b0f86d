// How much of a drawing falls onto the chart. Internal to worker/printing.
#pragma once

#include "worker/printing/print.hpp"

namespace vacuform {

// The fraction of the drawing's ink inside the chart's triangles in pattern coordinates, in [0, 1], measured
// on a grid of a thousand cells along the drawing's longer side.
double ink_on_chart(const FormedSheet& sheet, const Flattening& flattening,
                    const std::vector<Eigen::Vector2d>& pattern_uv, const Pattern& pattern);

}  // namespace vacuform
