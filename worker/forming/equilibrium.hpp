// Static equilibrium of a membrane whose clamped and stuck vertices are held: minimization by limited-memory BFGS
// (Nocedal & Wright, Numerical Optimization, 2006, algorithm 7.4) on the free vertices alone.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "worker/forming/free_membrane.hpp"
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
  // What one evaluation gives: the slope along direction_, and the largest force on a free vertex.
  struct Value {
    double energy = 0, slope = 0, force = 0;
  };
  struct Descent {
    double slope = 0, longest = 0;  // motion of a vertex
  };

  // At x_; sets trial_gradient_.
  Value evaluate(const Pull& pull);
  // Sets direction_ from the preconditioned gradient and the pairs.
  Descent choose_direction();
  // x_ is the base and a step along the direction.
  void move(double step);
  // How far a vertex at the base is from its start.
  double moved() const;
  // Goes over to the gradient at the new base, after a step. Keeps the pair if the curvature along it is positive.
  void remember(double step);

  // work(part, begin, end) over the free vertices in fixed parts: sums over them are the same at any number of threads.
  static constexpr int parts = 8;
  template <class Work>
  void in_parts(const Work& work) const;

  const Membrane& membrane_;
  const SheetGrid& grid_;
  std::vector<double> rest_area_;  // of each vertex
  FreeMembrane free_membrane_;
  Preconditioner preconditioner_;
  int worn_ = 0;  // iterations since the last factorization of the preconditioner

  // Of the vertices of free_membrane_, in its order: the free ones, then the held ones beside them.
  std::vector<Column> start_, base_, x_;
  // Of the free vertices.
  std::vector<Column> gradient_, trial_gradient_;
  std::vector<Preconditioner::Direction> direction_, preconditioned_, trial_preconditioned_;

  // Limited-memory BFGS in its compact form (Byrd, Nocedal, Schnabel, "Representations of quasi-Newton matrices and their
  // use in limited memory methods", Mathematical Programming 1994, theorem 2.2): with the products of all pairs at hand,
  // a direction takes one pass over them. A pair is the step s and z, the preconditioned change of the gradient y.
  static constexpr int memory = 5;
  using Products = Eigen::Matrix<double, memory + 1, memory + 1>;
  int pairs_ = 0;  // the oldest first; one more place for the newest
  std::array<std::vector<Preconditioner::Direction>, memory + 1> s_, z_;
  Products sy_ = Products::Zero(), zy_ = Products::Zero();
  Eigen::Matrix<double, memory + 1, 1> sg_, zg_;  // with the gradient
};

}  // namespace vacuform
