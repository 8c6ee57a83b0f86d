// The preconditioner of the membrane's equilibrium: a cheap stand-in for the inverse of its Hessian.
//
// A membrane resists stretching in its plane by its modulus, and moving along its normal by its tension alone, which is
// tens of times less on a sheet that is hardly stretched. So there are two scalar operators on the free vertices, one
// for each, each with a sparse Cholesky factor; a gradient is split at every vertex by the sheet's normal, the tangential
// part is solved with one factor, the normal part with the other, and both are projected back.
//
// The factors are kept in single precision, side by side, and solved for all four components at once; the two halves of
// the sheet that the nested dissection separates are solved on two threads. The result is the same on any number.
#pragma once

#include <memory>
#include <vector>

#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"
#include "worker/numerics/sparse_cholesky.hpp"

namespace vacuform {

class Preconditioner {
 public:
  Preconditioner(const Membrane& membrane, const SheetGrid& grid);

  // Factors both operators as they are at x, on the vertices that are not held.
  void factor(const std::vector<char>& held, const Points& x);
  bool factored() const { return !vertex_.empty(); }

  // The vertices that move from now on, all among those that were factored, at x. The factors stay as they are:
  // restricted to fewer vertices they are still symmetric and positive definite, a little too soft.
  void restrict_to(const std::vector<int>& vertices, const Points& x);

  // Gradient at the moving vertices in, the direction that the preconditioner makes of it out (3 x vertices).
  void apply(const Points& gradient, Points& direction);

 private:
  using Quad = Eigen::Array4f;  // the three tangential components and the normal one

  void eliminate(int begin, int end, std::vector<Quad>& separator);
  void substitute(int begin, int end);

  const Membrane& membrane_;
  const SheetGrid& grid_;
  std::vector<int> neighbour_start_, neighbour_;  // per vertex, ascending in elimination order
  std::vector<int> position_;                     // in the elimination order, per vertex

  // The factors L D L' of both operators, rows in elimination order: the first half, the second, the separator.
  std::vector<int> vertex_;         // of each row
  std::vector<int> row_of_vertex_;  // -1: held when factored
  int second_half_ = 0, separator_ = 0;
  std::vector<int> column_start_, row_;
  std::vector<Eigen::Array2f> value_;  // tangential, normal
  std::vector<Quad> inverse_diagonal_;

  std::vector<int> moving_;  // rows of the moving vertices
  Points normal_;            // of the sheet at them
  std::vector<Quad> rhs_, first_carry_, second_carry_;
};

}  // namespace vacuform
