// Dense factorizations, compiled once: Eigen's templates for them cost seconds in every file that uses them.
#pragma once

#include <Eigen/Core>

namespace vacuform {

// Solves A x = b for a symmetric, positive definite A (LDL^T with pivoting).
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::Vector4d solve_symmetric(const Eigen::Matrix4d& A, const Eigen::Vector4d& b);

// The x of least |A x - b|, for an A of full column rank (QR with column pivoting).
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::Vector2d least_squares(const Eigen::Matrix<double, 3, 2>& A, const Eigen::Vector3d& b);

// The shortest x of least |A x - b|, for an A of any rank (complete orthogonal decomposition). Pivots below `threshold`
// times the largest count as 0; without one, those at rounding do.
Eigen::VectorXd shortest_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::VectorXd shortest_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double threshold);
Eigen::Vector3d shortest_least_squares(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);

// Eigenvalues of a symmetric matrix, ascending, and their unit eigenvectors, one a column.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

}  // namespace vacuform
