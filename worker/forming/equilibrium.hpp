// Static equilibrium of a membrane whose clamped and stuck vertices are held: minimization by limited-memory BFGS
// (Nocedal & Wright, Numerical Optimization, 2006, algorithm 7.4) on the free vertices alone.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "worker/forming/membrane.hpp"
#include "worker/forming/preconditioner.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

class Equilibrium {
 public:
  // When a solve ends. Forces are in units of shear modulus x thickness x mm, lengths in mm.
  struct Limits {
    double force = 0;   // at rest: no nodal force on a free vertex is larger
    double motion = 0;  // and: no vertex moved further in each of the last three iterations
    double stride = std::numeric_limits<double>::infinity();  // no vertex moves further in one iteration
    double range =
        std::numeric_limits<double>::infinity();  // stop: a vertex is further from where it started
    int iterations = 0;
  };
  // The loads on the sheet: a pressure, and the weight of its unit rest area along -z, both as Membrane counts them.
  struct Pull {
    double pressure = 0, weight = 0;
  };
  struct Outcome {
    bool at_rest = false;
    bool ran_away = false;  // beyond the range
    int iterations = 0;
    double residual = 0;  // largest nodal force on a free vertex
  };

  Equilibrium(const Membrane& membrane, const SheetGrid& grid);

  // Declares which vertices are held from now on. A held vertex is never released. `fresh`: the stiffness of the
  // membrane has changed in a way that the iterations since the last call do not show.
  void hold(const std::vector<char>& held, const Points& x, bool fresh = false);

  // Call this after the rest shape of triangles has changed.
  void weigh();

  // Moves the free vertices of x towards equilibrium. Checks for cancellation at every iteration.
  Outcome solve(Points& x, const Pull& pull, const Limits& limits, const Context& context);

  // The force of the weight on a vertex, as a gradient.
  Eigen::Vector3d weight_of(std::size_t vertex, double weight) const {
    return {0, 0, weight * rest_area_[vertex]};
  }

 private:
  // Positions of all vertices in, gradient at the free ones out (3 x free).
  double energy(const Points& x, const Pull& pull, Points& gradient);

  const Membrane& membrane_;
  const SheetGrid& grid_;
  std::vector<double> rest_area_;  // of each vertex
  std::vector<int> index_, free_;  // vertex to row among the free ones (-1: held) and back
  std::vector<int> active_;        // triangles with a free corner
  int middle_ = 0;                 // of the active triangles: each half is summed separately
  std::array<Points, 2> halves_;   // their gradients, each with a column for the held vertices
  Preconditioner preconditioner_;
  int worn_ = 0;  // iterations since the last factorization of the preconditioner
};

}  // namespace vacuform
