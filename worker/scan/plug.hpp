// A mold on a straight plug, which lifts it above the platform so that the sheet turns down beside it and not at its
// edge.
#pragma once

#include "worker/scan/mold.hpp"

namespace vacuform {

// Raises the mold by `height_mm` and extends the rim of its base (the faces that lie on the platform, with all their
// outlines and holes) straight down to z = 0. The top, the undercuts and their warning move with it. The mold stays
// watertight, with coordinates that mold.stl holds exactly; its volume grows by base area times height. A height of 0
// returns the mold as it is. O(n log n) in the base's triangles. Pure. Errors: unusable_scan if less than 1 mm2 of the
// mold lies on the platform.
Result<Mold> on_plug(Mold mold, double height_mm);

}  // namespace vacuform
