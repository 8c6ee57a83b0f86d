// Marks on the mold that show how the print lies on it. Internal to worker/inspection.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The mold with slots in its base along the sheet's axes s = 0 and t = 0, which are the middles of the print's sides.
// They are 1.5 mm wide, 1 mm deep and 10 mm long, near the base's edge; the one towards +t is 20 mm long. A slot prints
// without supports, and a straightedge or a pin fits into it. It is left out if it would have less than a millimetre of
// wall. Watertight, with coordinates that STL holds, if the mold is; a mold without a flat base at z = 0 is returned as
// it is.
TriangleMesh marked_mold(const TriangleMesh& mold);

}  // namespace vacuform
