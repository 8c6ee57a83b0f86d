// The coupling of every loop of an array with every other loop, not only with its neighbours.
//
// Overlap nulls only neighbours. The remaining coupling is in the distant pairs: for coplanar circles at critical
// overlap (1.516 radii apart) the next-nearest pairs (2.626 radii apart) couple by about -0.02. No overlap can null
// them, because they do not touch.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "worker/stage/context.hpp"

namespace vacuform {

// A closed polyline in space, mm, the last point joined to the first, and its self-inductance (inductance.hpp). Without
// points, or if the inductance is not above zero, the loop couples with nothing.
struct InductiveLoop {
  std::vector<Eigen::Vector3d> line;
  double self_nh = 0;
};

// Symmetric; k = M / sqrt(L1 L2), 1 on the diagonal. NaN if one of the two couples with nothing.
class CouplingMatrix {
 public:
  explicit CouplingMatrix(int count = 0);
  int count() const { return count_; }
  double operator()(int a, int b) const { return k_[index(a, b)]; }
  void set(int a, int b, double k) { k_[index(a, b)] = k_[index(b, a)] = k; }

 private:
  std::size_t index(int a, int b) const {
    return static_cast<std::size_t>(a) * static_cast<std::size_t>(count_) + static_cast<std::size_t>(b);
  }
  int count_;
  std::vector<double> k_;
};

// Above this many coils only neighbours are coupled.
inline constexpr std::size_t most_coupled_coils = 256;

// Loops whose centres are farther apart than this many times the reach of the larger one (the distance from its centre
// to its farthest point) count as magnetic dipoles.
inline constexpr double dipole_distance = 10;

// Neumann's integral for near pairs. Far ones (dipole_distance) are dipoles, M = mu0 / (4 pi) [3 (A.r)(B.r) / r^5 - A.B
// / r^3] with the vector areas A and B of the loops; the error in k is less than 3e-5. With two cores 64 loops of 120
// points on a head take a second, 256 of them seven. Reports no progress. Deterministic for any number of threads. Errors:
// cancelled.
Result<CouplingMatrix> coupling_matrix(const std::vector<InductiveLoop>& loops, const Context& context);

// The pair with the strongest coupling among some pairs of an array.
struct StrongestPair {
  int a = 0, b = 0;  // a < b
  double k = 0;      // with its sign
};
// The pair with the largest |k| among the loops that `counts` admits, the first one of equals; nothing if there is no
// pair.
std::optional<StrongestPair> strongest_pair(const CouplingMatrix& matrix,
                                            const std::function<bool(int)>& counts);

// The root mean square of k over all pairs that couple; 0 without one.
double rms(const CouplingMatrix& matrix);

}  // namespace vacuform
