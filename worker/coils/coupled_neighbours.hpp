// Coupling between the neighbours of a placement, and what is reported about it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

// Computes the couplings of the pairs of the placement. With coils.decouple it computes them before and after the coils
// are moved and resized (decoupling.hpp); "coils-moved" warns when a coil moved by more than 10 mm. `drawing` is what
// place() laid out. Deterministic. Errors: cancelled.
Result<void> add_couplings(const ChartedSurface& charted, const Drawing& drawing, const Settings& settings,
                           const Context& context, Placement& placement);

// Two neighbours that both lie on the head.
struct CoupledNeighbours {
  std::string a, b;                // ids
  double k = 0;                    // with its sign
  double mm = 0;                   // distance of the centres
  Eigen::Vector3d place{0, 0, 0};  // between the centres, mm
};

// The pairs of a placement whose coupling is known, as they were placed.
std::vector<CoupledNeighbours> coupled_neighbours(const Placement& placement, const Drawing& drawing);

// "coils-coupled" for the pairs with |k| of 0.01 or more, strongest first; nothing if there are no such pairs.
std::optional<Warning> coupling_warning(const std::vector<CoupledNeighbours>& pairs, bool decoupled);

}  // namespace vacuform
