// The printed conductors as solids on the formed part. Internal to worker/inspection.
#pragma once

#include <string>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// array.stl: text, mm; a solid for each loop and for each of its bridges, closed, of the thickness that circuit.ink_um has
// left after forming. Bridges rise over the dielectric by circuit.dielectric_um. Needs job.build.
std::string conductors_stl(const Finished& job);

}  // namespace vacuform
