// The layers of a print for CAD programs. Internal to worker/inspection.
#pragma once

#include <string>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// layers.dxf: R12 in ASCII, millimetres, origin the centre of the sheet, x = s and y = t, all seen from the outer face: nothing is
// mirrored. What each layer of the print paints, as closed polylines on a layer of its name, within .005 mm. Needs job.build.
std::string layers_dxf(const Finished& job);

}  // namespace vacuform
