// A net of springs brought to rest through time, by Verlet's method or by implicit Euler.
//
// Only the place of rest matters, so time here is the net's own: it starts from no velocity, with its true masses, and
// a drag on every mass damps the slowest motion critically. The drag's coefficient is twice the frequency that the
// present motion has by Rayleigh's quotient (Oakley & Knight, "Adaptive dynamic relaxation algorithm for non-linear
// hyperelastic structures", Comput. Methods Appl. Mech. Engrg. 1995).
//
// Implicit Euler solves (M - dt df/dv - dt^2 df/dx) dv = dt (f + dt df/dx v), as Baraff & Witkin ("Large steps in cloth
// simulation", SIGGRAPH 1998), with conjugate gradients preconditioned by the blocks on the diagonal. The matrix is
// the true one, of compressed springs and of the pressure too: with the definite stand-in that is usual for cloth a
// sheet that wrinkles takes twenty times as many steps. Where it is indefinite the iteration ends at the first
// direction of negative curvature with what it has (Steihaug, "The conjugate gradient method and trust regions in
// large scale optimization", SIAM J. Numer. Anal. 1983), and no step moves a vertex further than `longest_move`.
#pragma once

#include "api/settings.hpp"
#include "worker/forming/spring_net.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct Load {
  double pressure = 0;  // N/mm^2
  double gravity = 0;   // mm/ms^2
};

class Settling {
 public:
  struct Outcome {
    bool at_rest = false;
    bool blew_up = false;  // the places are void
    double step_ms = 0;
    int steps = 0;
    double residual = 0;  // largest force on a moving vertex, N
    double kinetic = 0;   // energy, N mm = mJ
  };

  // At rest, no moving vertex feels more than `tolerance` N, and the kinetic energy is at most what that force gives
  // to all of them over a hundredth of `longest_move` mm. Without `step_ms` Verlet takes four fifths of its limit of
  // stability, implicit Euler three hundred times that limit.
  Settling(Integrator integrator, std::optional<double> step_ms, double tolerance, double longest_move)
      : integrator_(integrator), step_ms_(step_ms), tolerance_(tolerance), longest_move_(longest_move) {}

  // Moves x (one column a vertex of the part) to rest, or until it gives up, after five seconds of the net's time.
  // Reports `done` as the stage's progress. Deterministic. Errors: cancelled.
  Result<Outcome> settle(const SpringNet& part, Points& x, const Load& load, const Context& context,
                         double done) const;

 private:
  struct Motion;
  Result<void> verlet(Motion& motion, double dt) const;
  Result<void> implicit_euler(Motion& motion, double dt) const;

  Integrator integrator_;
  std::optional<double> step_ms_;
  double tolerance_, longest_move_;
};

}  // namespace vacuform
