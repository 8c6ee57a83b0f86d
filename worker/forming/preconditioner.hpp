// The preconditioner of the membrane's equilibrium: a cheap stand-in for the inverse of its Hessian.
//
// A membrane resists stretching in its plane by its modulus, and moving along its normal by its tension alone, which is
// tens of times less on a sheet that is hardly stretched. So there are two scalar operators on the free vertices, one
// for each, each with a sparse Cholesky factor; a gradient is split at every vertex by the sheet's normal, the tangential
// part is solved with one factor, the normal part with the other, and both are projected back.
#pragma once

#include <span>
#include <vector>

#include "worker/forming/free_membrane.hpp"
#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"
#include "worker/numerics/paired_cholesky.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

class Preconditioner {
 public:
  Preconditioner(const Membrane& membrane, const SheetGrid& grid);

  // Factors both operators as they are at x, on the vertices that are not held.
  void factor(const std::vector<char>& held, const Points& x);
  bool factored() const { return !vertex_.empty(); }

  // The vertices that move from now on, all among those that were factored, at x. The factors stay as they are:
  // restricted to fewer vertices they are still symmetric and positive definite, a little too soft.
  void restrict_to(std::span<const int> vertices, const Points& x);

  // x, y, z and 0.
  using Direction = Eigen::Array4f;
  // Gradient at the moving vertices in, the direction that the preconditioner makes of it out.
  void apply(const std::vector<Column>& gradient, std::vector<Direction>& direction);

 private:
  const Membrane& membrane_;
  const SheetGrid& grid_;
  const VertexFans fans_;
  PairedCholesky cholesky_;         // rows in elimination order
  std::vector<int> vertex_;         // of each row
  std::vector<int> row_of_vertex_;  // -1: held when factored
  std::vector<PairedCholesky::Element> elements_;

  std::vector<int> moving_;        // rows of the moving vertices
  std::vector<Direction> normal_;  // of the sheet at them
  std::vector<PairedCholesky::Quad> rhs_;
};

}  // namespace vacuform
