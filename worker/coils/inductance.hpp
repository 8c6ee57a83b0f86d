// Inductance of thin printed loops in space.
#pragma once

#include <Eigen/Core>
#include <span>

namespace vacuform {

// A closed polyline, the last point joined to the first, mm. At least three points.
using Loop = std::span<const Eigen::Vector3d>;

constexpr double mu0_over_4pi = 0.1;  // nH per mm: 1e-7 H/m

// Mutual inductance by Neumann's double integral, nH. Exact for each pair of straight segments in one of the two
// integrals (or to better than 1e-4 of sqrt(L1 L2) for loops of a hundred points), also if the loops touch or cross
// without touching: crossing conductors are `gap_mm` apart. The sign follows the sense of the loops.
double mutual_inductance_nh(Loop a, Loop b, double gap_mm = 0.1);

// Self-inductance of a loop of a flat strip `width_mm` wide: Neumann's integral over the loop and itself with the
// geometric mean distance of the strip (half width 4: L = mu0 a [ln(8 a / b) - 2], b = width / 4, for a circle), nH.
double self_inductance_nh(Loop loop, double width_mm);

// M / sqrt(L1 L2).
double coupling(Loop a, double width_a_mm, Loop b, double width_b_mm);

}  // namespace vacuform
