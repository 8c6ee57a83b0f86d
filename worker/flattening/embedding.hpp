// Checks whether a chart covers no place of the plane twice, and makes a map with that property from any start.
#pragma once

#include "worker/flattening/chart.hpp"

namespace vacuform {

// How many pairs of border edges of the chart cross or touch, not counting adjacent edges. A disk without turned-over
// triangles and without crossings covers no point of the plane twice.
int border_crossings(const Chart& chart);

// Tutte's embedding (1963) with the border on a circle, by its lengths, and the area of the inked surface: in exact
// arithmetic no triangle is turned over and nothing overlaps. Returns false and leaves the chart unchanged if it is not
// a disk.
bool embed_on_disk(Chart& chart);

}  // namespace vacuform
