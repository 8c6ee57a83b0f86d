// The symmetric Dirichlet energy of one triangle: its value, its gradient and the positive semidefinite part of its
// Hessian, as functions of the Jacobian J.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace vacuform {

// Psi = |J|^2 + |J^-1|^2 = s1^2 + s2^2 + s1^-2 + s2^-2; infinite unless det J > 0. 4 where J is a rotation.
double symmetric_dirichlet(const Eigen::Matrix2d& J);

// Psi to second order about J, which must have det J > 0. As vectors, matrices are (J00, J10, J01, J11).
struct SymmetricDirichlet {
  double energy;
  Eigen::Matrix2d gradient;  // dPsi/dJ
  // The Hessian is sum eigenvalue[i] direction[i] direction[i]' (Smith, de Goes, Kim 2019, section 4): of the scalings
  // along the two singular directions, the flip and the twist. Only the twist's can be negative; it is 0 then.
  Eigen::Vector4d eigenvalues;
  Eigen::Matrix4d directions;  // orthonormal columns
};
SymmetricDirichlet symmetric_dirichlet_expansion(const Eigen::Matrix2d& J);

}  // namespace vacuform
