// The coils of a print as circuits. Internal to worker/inspection and worker/pipeline.
#pragma once

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// Of the coils on the head that have an inductance, from the loops of `vectors` (all conductors, of both faces). The body is a
// sphere of least squares through the part of the sheet that lies on the mold, less the sheet's thickness and
// scan.clearance_mm. Nothing without such coils.
std::optional<CircuitFigures> circuit_figures(const Finished& job, const VectorPrint& vectors);

}  // namespace vacuform
