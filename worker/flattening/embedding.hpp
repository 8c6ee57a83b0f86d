// Whether a chart lies in the plane without covering anything twice, and a map that does whatever the start.
#pragma once

#include "worker/flattening/chart.hpp"

namespace vacuform {

// How many pairs of the chart's border edges cross or touch, neighbours apart. A disk without triangles turned over and
// without crossings covers no point of the plane twice.
int border_crossings(const Chart& chart);

// Tutte's embedding (1963) with the border on a circle, by its lengths, and the inked surface's area: in exact arithmetic
// no triangle is turned over and nothing overlaps. False, and the chart as it was, when it is no disk.
bool embed_on_disk(Chart& chart);

}  // namespace vacuform
