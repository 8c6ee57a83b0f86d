// How much of a drawing falls onto the charts. Internal to worker/printing.
#pragma once

#include "worker/pattern/pattern.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

// The fraction of the ink of the drawing inside the triangles of the charts in pattern coordinates, in [0, 1], measured
// on a grid of a thousand cells along the longer side of the drawing.
double ink_on_charts(const std::vector<Segment>& charts, const Pattern& pattern);

}  // namespace vacuform
