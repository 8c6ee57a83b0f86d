// A mold on a straight plug, which lifts it above the platform so that the sheet turns down beside it and not at its
// edge.
#pragma once

#include "worker/scan/mold.hpp"

namespace vacuform {

// Raises the mold by `height_mm` and draws the rim of its base (the faces that lie on the platform, with all their
// outlines and holes) straight down to z = 0; top, undercuts and their warning move along. Stays
// watertight and in coordinates that mold.stl holds exactly; its volume grows by base area times height. A height of
// 0 gives the mold as it is. O(n log n) in the base's triangles. Pure.
// Errors: unusable_scan when less than 1 mm2 of the mold lies on the platform.
Result<Mold> on_plug(Mold mold, double height_mm);

}  // namespace vacuform
