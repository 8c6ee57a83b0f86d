// Sparse Cholesky factorization of the large symmetric positive definite matrices of flattening, on one thread.
//
// Multifrontal (Duff, Reid 1983; Liu 1992) on the supernodes that CHOLMOD's analysis finds (Chen et al. 2008): dense
// blocks, factored by Eigen. CHOLMOD's own supernodal factorization needs a BLAS, and Debian's default one is no faster
// than no supernodes at all; a tuned one rounds differently on another processor. This code is three to five times as
// fast as either without them and gives the same bytes everywhere.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/numerics/symmetric_matrix.hpp"

namespace vacuform {

// One analysis serves many factorizations of the same pattern, one factorization many solves.
class SupernodalCholesky {
 public:
  // Orders (minimum degree) and analyses the pattern; the values are not looked at. O(entries of the factor). Unknowns
  // that come in groups of `group` neighbours with the same pattern, as the coordinates of a vertex do, are ordered as one.
  explicit SupernodalCholesky(const SymmetricMatrix& pattern, int group = 1);

  // False when the matrix is not positive definite. The pattern must be the one analysed.
  bool factor(const SymmetricMatrix& matrix);
  // Solves A X = B in place for the C columns of B at once. Needs factor() first.
  template <int C>
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, C, C == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  void solve(Columns<1>& B) const;
  void solve(Columns<2>& B) const;

 private:
  struct Supernode {
    int first = 0, columns = 0;  // its columns in the order of elimination
    int rows = 0;                // of its block: its own columns, then those below that it meets
    int parent = -1;
    std::size_t index = 0, value = 0;  // where its rows stand in rows_, its block in factor_
  };
  void find_supernodes(const SymmetricMatrix& pattern, int group);
  void find_slots(const SymmetricMatrix& pattern);
  template <int C>
  void substitute(Columns<C>& B) const;

  int size_ = 0;
  std::vector<Supernode> supernodes_;  // children before their parents
  std::vector<int> order_;             // order_[k]: the row of the matrix that is eliminated as k-th
  std::vector<int> owner_;             // the supernode of the k-th
  std::vector<int> rows_;              // in the order of elimination, ascending within a supernode
  std::vector<int> in_parent_;         // parallel to rows_: the same row's place in the parent's block
  std::vector<std::size_t> slot_;      // per entry of the matrix: its place in factor_
  std::vector<double> factor_;         // blocks of rows x columns, column by column
};

}  // namespace vacuform
