// The membrane: the clamped sheet descends over the mold, then the vacuum draws it down until everything rests.
//
// Quasi-static: after every small advance of the frame or of the pressure the free sheet is brought to rest, the
// straight way of each free vertex is followed to its first touch, what touched sticks there for good, and the rest
// is brought to rest again. An advance of pressure moves no vertex further than a part of the grid spacing before
// contact is looked for, so the sheet follows a path even where a bubble snaps through.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "worker/forming/equilibrium.hpp"
#include "worker/forming/process.hpp"

namespace vacuform {

namespace {

class Descent {
 public:
  Descent(const Process& process, SheetState& state, const Context& context)
      : process_(process),
        sheet_(process.sheet),
        machine_(process.machine),
        grid_(process.grid),
        membrane_(grid_.rest, grid_.triangles, process.forming.law, process.stiffness),
        equilibrium_(membrane_, grid_.triangles, grid_.elimination_order),
        context_(context),
        top_(process.top_mm),
        state_(state),
        x_(state.x),
        held_(state.held),
        summary_(state.summary) {}

  Result<void> run() {
    VACUFORM_CHECK(drape());
    VACUFORM_CHECK(draw());
    balance();
    return {};
  }

 private:
  // The frame descends from the mold's top to its final height.
  Result<void> drape() {
    const double travel = top_ - machine_.drape_height_mm;
    if (travel <= 0) return {};
    const int steps = std::max(10, static_cast<int>(std::ceil(travel / sheet_.resolution_mm)));
    Points before = x_;
    for (int k = 1; k <= steps; ++k) {
      VACUFORM_CHECK(context_.step(Stage::forming, 0.5 * (k - 1) / steps));
      equilibrium_.hold(held_, x_);
      // The free sheet goes on as it went, the frame by one step.
      Points y = x_;
      for (std::size_t i = 0; i < held_.size(); ++i)
        if (grid_.clamped[i])
          y(2, i) = top_ - travel * k / steps;
        else if (!held_[i])
          y.col(i) = k == 1 ? Eigen::Vector3d(x_(0, i), x_(1, i), top_ - travel / steps)
                            : Eigen::Vector3d(2 * x_.col(i) - before.col(i));
      for (bool again = true; again;) {
        VACUFORM_CHECK(settle(y));
        again = state_.follow(process_, y, double(k - 1) / steps, double(k) / steps) > 0;
        if (again) equilibrium_.hold(held_, y);
      }
      before = x_;
      x_ = y;
      ++summary_.drape_steps;
    }
    return {};
  }

  // The vacuum ramps from nothing to its limit.
  Result<void> draw() {
    const double limit = machine_.vacuum_kpa / (process_.modulus_kpa * sheet_.thickness_mm);
    const double h = sheet_.resolution_mm;
    const double first = std::min(limit, 0.1 / machine_.window_width_mm);
    double p = first;
    ceiling_.emplace(x_, grid_.triangles);
    for (int step = 0; step < most_steps; ++step) {
      VACUFORM_CHECK(
          context_.step(Stage::forming, 0.5 + 0.5 * std::log(p / first) / std::log(limit / first + 1)));
      const bool last = p >= limit;
      const double tolerance = last ? final_tolerance * p * h * h
                                    : std::max(ramp_tolerance * p * h * h, 0.1 * drape_tolerance * h);
      equilibrium_.hold(held_, x_);
      Points y = x_;
      const auto outcome = equilibrium_.solve(y, p, tolerance, 1.5 * h, 300, context_);
      if (context_.cancelled()) return fail(Code::cancelled, "cancelled");
      summary_.iterations += outcome.iterations;
      ++summary_.vacuum_steps;
      const double now = 1 + p / limit;
      const int touched = state_.follow(process_, y, now, now, &*ceiling_);
      x_ = y;
      if (!outcome.at_rest || (last && touched > 0)) continue;
      if (last) {
        summary_.converged = true;
        pressure_ = p;
        return {};
      }
      p = std::min(limit, ramp_growth * p);
    }
    return fail(Code::no_equilibrium, "the sheet did not come to rest under the vacuum", "forming",
                "try another sheet.resolution_mm, or a lower machine.vacuum_kpa");
  }

  // The first steps pull an all but flat sheet, which has next to no stiffness against its own plane: they need not
  // settle, what they leave is evened out by the steps that follow.
  Result<void> settle(Points& y) {
    constexpr int iterations = 60;
    const auto outcome = equilibrium_.solve(y, 0, drape_tolerance * sheet_.resolution_mm,
                                            std::numeric_limits<double>::infinity(), iterations, context_);
    summary_.iterations += outcome.iterations;
    if (context_.cancelled()) return fail(Code::cancelled, "cancelled");
    return {};
  }

  // What is left out of balance, and what the supports carry.
  void balance() {
    Points force(3, x_.cols());
    membrane_.energy(x_, pressure_, force);
    double support = 0, largest_free = 0, projected = 0;
    for (std::size_t i = 0; i < held_.size(); ++i)
      if (held_[i])
        support += force(2, i);
      else
        largest_free = std::max(largest_free, force.col(i).norm());
    for (const Triangle& t : grid_.triangles) {
      const Eigen::Vector2d a = x_.col(t[0]).head<2>(), b = x_.col(t[1]).head<2>() - a,
                            c = x_.col(t[2]).head<2>() - a;
      projected += 0.5 * (b.x() * c.y() - b.y() * c.x());
    }
    summary_.residual = largest_free / (pressure_ * sheet_.resolution_mm * sheet_.resolution_mm);
    summary_.force_error = std::abs(support / (pressure_ * projected) - 1);
    summary_.pressure_kpa = pressure_ * process_.modulus_kpa * sheet_.thickness_mm;
  }

  // Out-of-balance forces, against the tension of a unit stretch while draping and against pressure times the
  // area of a cell on the ramp and at its end.
  static constexpr double drape_tolerance = 1e-3, ramp_tolerance = 1e-2, final_tolerance = 1e-4;
  static constexpr double ramp_growth = 1.3;  // of the pressure, a step
  static constexpr int most_steps = 3000;

  const Process& process_;
  const SheetSettings& sheet_;
  const MachineSettings& machine_;
  const SheetGrid& grid_;
  Membrane membrane_;
  Equilibrium equilibrium_;
  Context context_;
  double top_;
  SheetState& state_;
  Points& x_;
  std::vector<char>& held_;
  FormingSummary& summary_;
  // The sheet as draped: the vacuum pulls it down from there, so no part of it ever comes through from below.
  std::optional<SheetAsObstacle> ceiling_;
  double pressure_ = 0;
};

}  // namespace

Result<void> form_membrane(const Process& process, SheetState& state, const Context& context) {
  return Descent(process, state, context).run();
}

}  // namespace vacuform
