// Rebuilding a skin that cannot be closed as it is: loose triangles, patches with gaps, surfaces that cross
// themselves.
#pragma once

#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A watertight skin 0.1 mm outside an upright scan in mm that stands on z = 0. If the scan is open below, a plate half
// a millimetre under z = 0 closes the new skin. Gaps of up to a hundredth of the size of the scan are bridged without a
// trace. Wider gaps need a wider bridging, up to 15 %, which rounds corners more. Needs up to five wraps, seconds on a
// head; the number of triangles limits their work. If the budget runs out, the wider bridging is kept. Errors: those of
// wrap(), if even the widest exceeds the budget.
Result<TriangleMesh> rebuild(const TriangleMesh& skin, const ScanProgress& progress);

}  // namespace vacuform
