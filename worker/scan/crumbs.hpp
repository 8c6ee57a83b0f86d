// Crumbs: what the cut leaves standing beside a mold.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Takes off pieces that the cut left standing beside the mold, below a thousandth of its volume: the tip of an ear, a
// curl. They would move the middle. Small bodies that stand in or on others are kept. Returns how many.
int drop_crumbs(TriangleMesh& cut);

}  // namespace vacuform
