// Pads that cannot be soldered, because something is printed over them.
#pragma once

#include <optional>
#include <vector>

#include "worker/conductors/electrical_check.hpp"

namespace vacuform {

// "pads-covered": of the gaps for a port or a capacitor, those where resist or a picture covers more than half of the trace
// beside them, on one side or both, as long as a pad is (coils.capacitor). Drawn gaps count too; printed capacitors need no
// solder, and a port with a tail is soldered at the pads of the tail. `placement` is that of the first face, `ink` that of the print. Nothing if all pads are free. Deterministic.
std::optional<Warning> covered_pads(const Drawing& drawing, const Placement& placement,
                                    const ArrayBuild& build, const std::vector<PrintedInk>& ink,
                                    const CoilSettings& settings);

}  // namespace vacuform
