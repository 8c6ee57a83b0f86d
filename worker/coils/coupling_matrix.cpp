#include "worker/coils/coupling_matrix.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/coils/inductance.hpp"
#include "worker/stage/batches.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

struct Dipole {
  Vector3d middle{0, 0, 0}, area{0, 0, 0};  // of the points; the loop's vector area, mm2
  double reach = 0;
};

Dipole dipole_of(const std::vector<Vector3d>& line) {
  Dipole out;
  for (const Vector3d& p : line) out.middle += p / static_cast<double>(line.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector3d from = line[i] - out.middle, to = line[(i + 1) % line.size()] - out.middle;
    out.area += 0.5 * from.cross(to);
    out.reach = std::max(out.reach, from.norm());
  }
  return out;
}

double mutual_nh(const InductiveLoop& a, const Dipole& of_a, const InductiveLoop& b, const Dipole& of_b) {
  const Vector3d way = of_b.middle - of_a.middle;
  const double r = way.norm();
  if (r <= dipole_distance * std::max(of_a.reach, of_b.reach)) return mutual_inductance_nh(a.line, b.line);
  return mu0_over_4pi * (3 * of_a.area.dot(way) * of_b.area.dot(way) / (r * r) - of_a.area.dot(of_b.area)) /
         (r * r * r);
}

}  // namespace

CouplingMatrix::CouplingMatrix(int count)
    : count_(count),
      k_(static_cast<std::size_t>(count) * static_cast<std::size_t>(count),
         std::numeric_limits<double>::quiet_NaN()) {}

Result<CouplingMatrix> coupling_matrix(const std::vector<InductiveLoop>& loops, const Context& context) {
  const int count = static_cast<int>(loops.size());
  const auto loop = [&](int i) -> const InductiveLoop& { return loops[i]; };
  const auto couples = [&](int i) { return !loop(i).line.empty() && loop(i).self_nh > 0; };
  std::vector<Dipole> dipoles;
  for (const InductiveLoop& one : loops) dipoles.push_back(dipole_of(one.line));
  CouplingMatrix out(count);
  VACUFORM_CHECK(in_batches(loops.size(), 8, Stage::printing, context.silent(), [&](std::size_t row) {
    const int a = static_cast<int>(row);
    if (!couples(a)) return;
    out.set(a, a, 1);
    for (int b = 0; b < a; ++b)
      if (couples(b))
        out.set(a, b,
                mutual_nh(loop(a), dipoles[row], loop(b), dipoles[index(b)]) /
                    std::sqrt(loop(a).self_nh * loop(b).self_nh));
  }));
  return out;
}

std::optional<StrongestPair> strongest_pair(const CouplingMatrix& matrix,
                                            const std::function<bool(int)>& counts) {
  std::optional<StrongestPair> out;
  for (int a = 0; a < matrix.count(); ++a)
    for (int b = a + 1; counts(a) && b < matrix.count(); ++b)
      if (const double k = matrix(a, b);
          counts(b) && std::isfinite(k) && (!out || std::abs(k) > std::abs(out->k)))
        out = StrongestPair{a, b, k};
  return out;
}

double rms(const CouplingMatrix& matrix) {
  double squares = 0;
  int pairs = 0;
  for (int a = 0; a < matrix.count(); ++a)
    for (int b = a + 1; b < matrix.count(); ++b)
      if (const double k = matrix(a, b); std::isfinite(k)) squares += k * k, ++pairs;
  return pairs > 0 ? std::sqrt(squares / pairs) : 0;
}

}  // namespace vacuform
