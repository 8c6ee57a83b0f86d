// Rebuilding a skin that cannot be closed as it is: loose triangles, patches with gaps, surfaces that cross
// themselves.
#pragma once

#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A watertight skin 0.1 mm outside an upright scan in mm that stands on z = 0. If the scan is open below, a plate half
// a millimetre under z = 0 closes the new skin. Gaps of up to a hundredth of the size of the scan are bridged without a
// trace. If that is not enough the bridging grows, up to 15 %, and corners lose more with it. Needs up to five wraps,
// seconds on a head; the number of triangles bounds their work, and if the budget runs out the wider bridging is kept.
// Errors: those of wrap(), if not even the widest is within the bound.
Result<TriangleMesh> rebuild(const TriangleMesh& skin, const ScanProgress& progress);

}  // namespace vacuform
