// Brings a net of springs to rest through time, by Verlet's method or by implicit Euler.
//
// Only the rest position matters, so the simulated time is artificial: it starts from zero velocity, with the true
// masses, and a drag on every mass damps the slowest motion critically. The drag coefficient is twice the frequency of
// the present motion by Rayleigh's quotient (Oakley & Knight, "Adaptive dynamic relaxation algorithm for non-linear
// hyperelastic structures", Comput. Methods Appl. Mech. Engrg. 1995).
//
// Implicit Euler solves (M - dt df/dv - dt^2 df/dx) dv = dt (f + dt df/dx v), as Baraff & Witkin ("Large steps in cloth
// simulation", SIGGRAPH 1998), with conjugate gradients preconditioned by the diagonal blocks. The matrix is the exact
// one, including compressed springs and the pressure: with the definite approximation that is usual for cloth a sheet
// that wrinkles takes twenty times as many steps. Where it is indefinite the iteration ends at the first direction of
// negative curvature with its current result (Steihaug, "The conjugate gradient method and trust regions in large scale
// optimization", SIAM J. Numer. Anal. 1983), and no step moves a vertex further than `longest_move`.
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
    bool blew_up = false;  // the positions are invalid
    double step_ms = 0;
    int steps = 0;
    double residual = 0;  // largest force on a moving vertex, N
    double kinetic = 0;   // energy, N mm = mJ
  };

  // At rest, the force on every moving vertex is at most `tolerance` N, and the kinetic energy is at most what that
  // force gives to all of them over a hundredth of `longest_move` mm. Without `step_ms` Verlet uses four fifths of its
  // stability limit, implicit Euler three hundred times that limit.
  Settling(Integrator integrator, std::optional<double> step_ms, double tolerance, double longest_move)
      : integrator_(integrator), step_ms_(step_ms), tolerance_(tolerance), longest_move_(longest_move) {}

  // Moves x (one column per vertex of the part) to rest, or stops after five seconds of simulated time. Reports `done`
  // as the progress of the stage. Deterministic. Errors: cancelled.
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
