// Sparse Cholesky factorization (CHOLMOD, Chen et al. 2008) of symmetric positive definite matrices, on one thread.
// One analysis serves many factorizations of the same pattern, one factorization many solves.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace vacuform {

// The lower triangle of a symmetric matrix, compressed by columns; rows ascend within a column, and every column
// begins with its diagonal.
struct SymmetricMatrix {
  int size = 0;
  std::vector<int> column_start;  // size + 1
  std::vector<int> row;
  std::vector<double> value;
};

class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  // Orders and analyses the pattern. `order` is an elimination order of all rows, or empty for AMD.
  void analyse(const SymmetricMatrix& matrix, const std::vector<int>& order = {});
  // False when the matrix is not positive definite. Needs analyse() of the same pattern first.
  bool factor(const SymmetricMatrix& matrix);
  // The factors of A = L D L': columns of the unit lower triangle L, ascending, with D in place of the diagonal. Valid
  // until the next factor(); in the order of the rows if analyse() was given the rows in their order.
  struct Factors {
    const int* column_start;
    const int* count;  // entries of each column
    const int* row;
    const double* value;
  };
  Factors factors() const;

  // Solves A X = B for all columns of B at once. Needs factor() first.
  void solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vacuform
