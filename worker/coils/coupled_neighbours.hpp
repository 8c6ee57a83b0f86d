// How the neighbours of a placement couple, and what a person is told of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

// Gives the pairs of the placement their couplings. With coils.decouple its coils are moved and resized between the two
// (decoupling.hpp); "coils-moved" warns when that led a coil more than 10 mm away. `drawing` is what place() laid.
// Deterministic. Errors: cancelled.
Result<void> add_couplings(const ChartedSurface& charted, const Drawing& drawing, const Settings& settings,
                           const Context& context, Placement& placement);

// Two neighbours that both lie on the head.
struct CoupledNeighbours {
  std::string a, b;                // ids
  double k = 0;                    // with its sign
  double mm = 0;                   // distance of the centres
  Eigen::Vector3d place{0, 0, 0};  // between the centres, mm
};

// Those of the pairs of a placement whose coupling is known, as they were placed.
std::vector<CoupledNeighbours> coupled_neighbours(const Placement& placement, const Drawing& drawing);

// "coils-coupled" about those of the pairs that have |k| of 0.01 or more, strongest first; nothing where there are none.
std::optional<Warning> coupling_warning(const std::vector<CoupledNeighbours>& pairs, bool decoupled);

}  // namespace vacuform
