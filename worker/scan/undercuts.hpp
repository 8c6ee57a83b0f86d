// Undercuts: what the sheet, coming from above, cannot reach. A grid of vertical rays finds the empty space that
// something overhangs; columns side by side whose empty spans meet are one pocket.
#pragma once

#include <vector>

#include "worker/context.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/triangle_mesh.hpp"

namespace vacuform {

struct Pocket {
  Undercut undercut;
  double begins;  // the highest place of its covered empty space, mm
};

// Pockets of a closed, outwards oriented mesh that stands on the plane z = floor, deepest first (ties: larger area, then
// order on the grid). Depth at a place is the horizontal distance to the nearest column that nothing overhangs there,
// less half a grid cell; a pocket's depth is its greatest. Spans lower than 0.2 mm are no pockets.
// `spacing`: of the rays, mm. Cost: columns times surfaces crossed, plus the search for depths.
Result<std::vector<Pocket>> find_pockets(const TriangleMesh& mesh, double floor, double spacing, const Context& context);

// The highest place at which a pocket begins that is worth trimming for: at least 1 mm deep and of at least `least_area`
// mm2 seen from above. `floor` when there is none.
double undercuts_begin(const std::vector<Pocket>& pockets, double floor, double least_area);

}  // namespace vacuform
