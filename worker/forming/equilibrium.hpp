// Static equilibrium of a membrane whose clamped and stuck vertices are held: minimization by limited-memory BFGS
// (Nocedal & Wright, Numerical Optimization, 2006, algorithm 7.4), preconditioned with a sparse Cholesky factor of a
// scalar stand-in for the Hessian (see Membrane::scalar_stiffness) on the free vertices alone.
#pragma once

#include <memory>
#include <vector>

#include "worker/context.hpp"
#include "worker/forming/membrane.hpp"
#include "worker/forming/sparse_cholesky.hpp"

namespace vacuform {

class Equilibrium {
 public:
  struct Outcome {
    bool at_rest = false;  // the residual is below the tolerance
    bool capped = false;   // stopped because a vertex had moved by the cap
    int iterations = 0;
    double residual = 0;  // largest nodal force on a free vertex, in units of shear modulus x thickness x mm
  };

  // `elimination_order` orders all vertices of the sheet for the factorization.
  Equilibrium(const Membrane& membrane, const std::vector<Triangle>& triangles,
              std::vector<int> elimination_order);

  // Declares which vertices are held from now on, and builds the preconditioner from the stiffness at x.
  void hold(const std::vector<char>& held, const Points& x);

  // Moves the free vertices of x towards rest under pressure p (see Membrane), by at most `cap` mm from where each
  // was on entry (then stops). At most `iterations` steps; looks at the cancellation at every one.
  Outcome solve(Points& x, double p, double tolerance, double cap, int iterations, const Context& context);

 private:
  // Positions of all vertices in, gradient at the free ones out (3 x free).
  double energy(const Points& x, double p, Points& gradient);
  void precondition(const Points& gradient, Points& direction);

  const Membrane& membrane_;
  const std::vector<Triangle>& triangles_;
  std::vector<int> order_;
  std::vector<int> index_, free_;           // vertex to row among the free ones (-1: held) and back
  std::vector<int> active_;                 // triangles with a free corner
  std::vector<int> corner_start_, corner_;  // per free vertex: its corners, 3 x (place in active_) + corner
  std::vector<Eigen::Matrix3d> corners_;    // gradients of the active triangles
  std::vector<double> energies_;            // of the active triangles
  SparseCholesky cholesky_;
  Eigen::MatrixXd rhs_, solution_;
};

}  // namespace vacuform
