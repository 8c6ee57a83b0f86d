// The coils of a print as circuits. Internal to worker/inspection and worker/pipeline.
#pragma once

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// The part of the sheet that lies on the mold as a sphere of least squares, less the sheet's thickness and scan.clearance_mm.
// Nothing if that leaves none.
std::optional<BodyBelow> body_below(const FormedSheet& sheet, const InkedSurface& surface,
                                    const Flattening& flattening, const Settings& settings);

// Of the coils on the head that have an inductance, from the loops of `vectors` (all conductors, of both faces). Nothing without
// such coils or a body.
std::optional<CircuitFigures> circuit_figures(const Finished& job, const VectorPrint& vectors);

}  // namespace vacuform
