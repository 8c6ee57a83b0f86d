// What a person is told of neighbours that couple.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

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
