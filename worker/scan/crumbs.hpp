// Crumbs: small pieces that the cut leaves beside a mold.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Removes pieces beside the mold that are smaller than a thousandth of its volume: the tip of an ear, a curl. They
// would shift the centre of the mold. Small bodies that stand in or on others are kept. Returns the number of pieces
// removed.
int drop_crumbs(TriangleMesh& cut);

}  // namespace vacuform
