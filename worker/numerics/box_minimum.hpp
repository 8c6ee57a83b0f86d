// The minimum of a convex quadratic function in a box.
#pragma once

#include <Eigen/Core>

namespace vacuform {

// The x between `low` and `high` at which x'Ax / 2 - b'x is least. A is symmetric and positive definite, low <= high, all
// finite. Exact but for the rounding of the result (K. Fischer, B. Gaertner, S. Schoenherr, F. Wessendorp: linear and
// quadratic programming, in CGAL), so meant for a handful of unknowns. Deterministic.
Eigen::VectorXd box_minimum(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Eigen::VectorXd& low,
                            const Eigen::VectorXd& high);

}  // namespace vacuform
