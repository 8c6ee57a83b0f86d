// What tells on the mold how the print lies on it. Internal to worker/inspection.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The mold with slots in its base along the sheet's axes s = 0 and t = 0, which are the middles of the print's sides: 1.5 mm
// wide, 1 mm deep and 10 mm long, near the base's edge; the one towards +t is 20 mm long. A slot prints without supports
// and takes a straightedge or a pin. Left out where the base leaves no room for it with a millimetre of wall. Watertight,
// with coordinates that STL holds, when the mold is; a mold without a flat base at z = 0 comes back as it is.
TriangleMesh marked_mold(const TriangleMesh& mold);

}  // namespace vacuform
