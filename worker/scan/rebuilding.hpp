// Rebuilding a skin that cannot be closed as it is: loose triangles, patches with gaps, surfaces that cross
// themselves.
#pragma once

#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A watertight skin 0.1 mm outside of an upright scan in mm that stands on z = 0. Where the scan is open
// below, the new skin is closed by a plate half a millimetre under z = 0. Gaps of up to a hundredth of the
// scan's size are bridged without a trace; where that is not enough the bridging grows, up to 15 %, and with
// it what corners lose. Takes up to five wraps, seconds on a head; their work is bounded by the number of triangles, and
// where it runs out the wider bridging stands. Errors: those of wrap(), when not even the widest is within the bound.
Result<TriangleMesh> rebuild(const TriangleMesh& skin, const ScanProgress& progress);

}  // namespace vacuform
