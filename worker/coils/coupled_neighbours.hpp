// Coupling between the loops of a placement, and what is reported about it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/coils/coupling_matrix.hpp"
#include "worker/coils/decoupling.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

// Computes the couplings of the pairs of the placement. With coils.decouple it computes them before and after the coils
// are moved and resized (decoupling.hpp); "coils-moved" warns when a coil moved by more than 10 mm,
// "coils-not-decoupled" that there are more than most_coupled_coils. `drawing` is what place() laid out. Deterministic.
// Errors: cancelled.
Result<void> add_couplings(const ChartedSurface& charted, const Drawing& drawing, const Settings& settings,
                           const Context& context, Placement& placement);

// Two loops that both lie on the head.
struct CoupledLoops {
  std::string a, b;                // ids
  double k = 0;                    // with its sign
  double mm = 0;                   // distance of the centres
  Eigen::Vector3d place{0, 0, 0};  // between the centres, mm
  bool neighbours = true, overlap = true;
};

// What a pair may couple by: neighbours by neighbours_k, others as distance leaves them, unnulled_k, which also counts for
// neighbours that do not overlap once they are decoupled.
inline constexpr double neighbours_k = 0.01;
inline double most_k(const CoupledLoops& pair, bool decoupled) {
  return pair.overlap || (pair.neighbours && !decoupled) ? neighbours_k : unnulled_k;
}

// A loop of an array, and two of them that are neighbours, by their places in it.
struct ArrayLoop {
  std::string id;
  Eigen::Vector3d centre{0, 0, 0};  // mm
  double radius_mm = 0;
  bool on_head = true;
};
struct NeighbourLoop {
  int a = 0, b = 0;
  std::optional<double> k;  // nothing: a loop is missing
  double mm = 0;            // distance of the centres
};

// The pairs on the head: neighbours, and of the others those that couple by neighbours_k or more. `matrix` holds all
// couplings, or nothing.
std::vector<CoupledLoops> coupled_loops(const std::vector<ArrayLoop>& loops,
                                        const std::vector<NeighbourLoop>& neighbours,
                                        const CouplingMatrix& matrix);

// The same of a placement, as its loops are placed. Errors: cancelled.
Result<std::vector<CoupledLoops>> coupled_loops(const Placement& placement, const Drawing& drawing,
                                                const Context& context);

// "coils-coupled" for the pairs at or above most_k(), strongest first; nothing if there are no such pairs.
std::optional<Warning> coupling_warning(const std::vector<CoupledLoops>& pairs, bool decoupled);

}  // namespace vacuform
