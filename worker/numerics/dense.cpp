#include "worker/numerics/dense.hpp"

#include <Eigen/Dense>

namespace vacuform {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd solve_symmetric(const MatrixXd& A, const VectorXd& b) { return A.ldlt().solve(b); }
MatrixXd solve_symmetric(const MatrixXd& A, const MatrixXd& B) { return A.ldlt().solve(B); }
Eigen::Vector4d solve_symmetric(const Eigen::Matrix4d& A, const Eigen::Vector4d& b) {
  return A.ldlt().solve(b);
}

MatrixXd least_squares(const MatrixXd& A, const MatrixXd& B) { return A.colPivHouseholderQr().solve(B); }
Eigen::Vector2d least_squares(const Eigen::Matrix<double, 3, 2>& A, const Eigen::Vector3d& b) {
  return A.colPivHouseholderQr().solve(b);
}

VectorXd shortest_least_squares(const MatrixXd& A, const VectorXd& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}
VectorXd shortest_least_squares(const MatrixXd& A, const VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(threshold);
  decomposition.compute(A);
  return decomposition.solve(b);
}
Eigen::Vector3d shortest_least_squares(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}

SymmetricEigen symmetric_eigen(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace vacuform
