#include "worker/flattening/symmetric_dirichlet_energy.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vacuform {

double symmetric_dirichlet(const Eigen::Matrix2d& J) {
  const double determinant = J.determinant();
  if (!(determinant > 0)) return std::numeric_limits<double>::infinity();
  return J.squaredNorm() * (1 + 1 / (determinant * determinant));
}

SymmetricDirichlet symmetric_dirichlet_expansion(const Eigen::Matrix2d& J) {
  // J = R(p) diag(s1, s2) R(q)' in closed form: its parts that keep and that reverse orientation have the moduli
  // (s1 + s2) / 2 and (s1 - s2) / 2 and the arguments p - q and p + q.
  const double e = (J(0, 0) + J(1, 1)) / 2, f = (J(1, 0) - J(0, 1)) / 2;
  const double g = (J(0, 0) - J(1, 1)) / 2, h = (J(1, 0) + J(0, 1)) / 2;
  const double keeps = std::hypot(e, f), reverses = std::hypot(g, h);
  const double determinant = J.determinant();
  const double s1 = keeps + reverses, s2 = determinant / s1;  // not keeps - reverses: no digits are lost
  const double sum = std::atan2(h, g), difference = std::atan2(f, e);
  const double p = (sum + difference) / 2, q = (sum - difference) / 2;
  const double cp = std::cos(p), sp = std::sin(p), cq = std::cos(q), sq = std::sin(q);

  Eigen::Matrix2d U, V;
  U << cp, -sp, sp, cp;
  V << cq, -sq, sq, cq;
  const double i1 = 1 / (s1 * s1), i2 = 1 / (s2 * s2), product = s1 * s2;
  const double d1 = 2 * s1 - 2 * i1 / s1, d2 = 2 * s2 - 2 * i2 / s2;

  SymmetricDirichlet out;
  out.energy = s1 * s1 + s2 * s2 + i1 + i2;
  out.gradient = U * Eigen::Vector2d(d1, d2).asDiagonal() * V.transpose();
  const double cube = product * product * product;
  out.eigenvalues << 2 + 6 * i1 * i1, 2 + 6 * i2 * i2, 2 + 2 * (s1 * s1 + product + s2 * s2) / cube,
      std::max(0.0, 2 - 2 * (s1 * s1 - product + s2 * s2) / cube);
  const double half = std::sqrt(0.5);
  const Eigen::Matrix2d a = U.col(0) * V.col(0).transpose(), b = U.col(1) * V.col(1).transpose(),
                        c = U.col(0) * V.col(1).transpose(), d = U.col(1) * V.col(0).transpose();
  const Eigen::Matrix2d flip = half * (c + d), twist = half * (d - c);
  out.directions << a.reshaped(), b.reshaped(), flip.reshaped(), twist.reshaped();
  return out;
}

}  // namespace vacuform
