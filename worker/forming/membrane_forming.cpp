// The membrane, elastic or viscoplastic: the clamped sheet descends over the mold, then the vacuum draws it down until
// everything rests.
//
// Quasi-static: after every small advance of the frame or of the vacuum the free sheet is brought to equilibrium, the
// straight path of each free vertex is followed to its first contact, and vertices that touch stick there permanently.
// Each contact changes how the rest moves. So an advance of the vacuum is only taken as far as the contact spreads by
// one row of vertices, or half a grid spacing if that is further; the next one continues from there with those rows
// held. Where a film is past its limit point (a balloon that snaps through at constant pressure) it moves on by half a
// spacing at a time.
//
// A fine sheet follows a coarse one: the descent is first simulated on grids of four and two times the spacing. The
// motion of a coarse sheet in each step is the first guess for the finer one. The result is the equilibrium of the fine
// sheet.
//
// A viscous sheet is an elastic one whose rest shape follows it: over dt it has the modulus viscosity / dt relative to
// its previous shape, which is the incremental form of a Newtonian membrane. With a yield stress the sheet is elastic,
// and the stress above the yield stress flows off.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "worker/forming/contact_spread.hpp"
#include "worker/forming/equilibrium.hpp"
#include "worker/forming/interpolation.hpp"
#include "worker/forming/material.hpp"
#include "worker/forming/point_contact.hpp"
#include "worker/forming/process.hpp"
#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

constexpr double gravity_m_s2 = 9.81;
constexpr double unlimited = std::numeric_limits<double>::infinity();

// The rest positions of a sheet: at first, then after each step of the frame.
struct Draped {
  const SheetGrid* grid;
  std::vector<Points> rests;
};

class Descent {
 public:
  // `guide` is a coarser sheet through the same descent, or null. `begin` and `end` are the progress of forming at the
  // beginning and the end of the descent; the frame descends by at most step_mm at a time, or by the steps of the
  // guide.
  Descent(const Process& process, SheetState& state, const Draped* guide, double step_mm, double begin,
          double end, const Context& context)
      : process_(process),
        machine_(process.machine),
        grid_(process.grid),
        flows_(process.forming.model == FormingModel::viscoplastic),
        viscous_(flows_ && process.forming.yield_kpa == 0),
        membrane_(grid_.rest, grid_.triangles, process.forming.law,
                  viscous_ ? process.viscosity : process.stiffness),
        equilibrium_(membrane_, grid_),
        context_(context),
        step_mm_(step_mm),
        most_growth_(1 + 0.3 * process.step_share),
        begin_(begin),
        end_(end),
        guide_(guide),
        state_(state),
        x_(state.x),
        before_(state.x),
        spacing_(process.sheet.resolution_mm),
        spread_(grid_),
        points_(process) {
    now_.frame_mm = process.top_mm;
    if (guide) interpolation_.emplace(*guide->grid, grid_);
  }

  Result<void> run() {
    VACUFORM_CHECK(sag());
    VACUFORM_CHECK(descend());
    ceiling_.emplace(x_, grid_.triangles);
    return draw();
  }

  // Only the descent, as a guide for a finer sheet.
  Result<Draped> drape() {
    rests_.emplace();
    VACUFORM_CHECK(sag());
    VACUFORM_CHECK(descend());
    return Draped{&process_.grid, std::move(*rests_)};
  }

 private:
  // The state of the process.
  struct Load {
    double frame_mm = 0;  // height of the clamp frame above the platform
    double seconds = 0;   // since the descent began
    double vacuum_s = 0;  // since the vacuum began
    double contact = 0;   // as FormedSheet::contact_time
  };

  // The weight of the hot sheet pulls it down before it meets the mold; the frame starts just high enough to avoid
  // contact.
  Result<void> sag() {
    if (!process_.forming.sag || viscous_) return {};
    const Load still;
    Points y = x_;
    for (std::size_t i = 0; i < grid_.rest.size(); ++i)  // a shallow bowl: a flat sheet cannot start
      y(2, i) -= 0.02 * machine_.window_width_mm * (1 - nearness_to_frame(grid_.rest[i], machine_));
    equilibrium_.hold(state_.held, y);
    VACUFORM_CHECK(solve(y, still, 0, {0, 0.1 * still_mm, stride(), unlimited, 1000}));
    const double lowest = y.row(2).minCoeff();
    y.row(2).array() += process_.top_mm - lowest;
    now_.frame_mm += process_.top_mm - lowest;
    x_ = before_ = y;
    return {};
  }

  // The frame descends to its final height.
  Result<void> descend() {
    if (rests_) rests_->assign(1, x_);
    const double start = now_.frame_mm, travel = start - machine_.drape_height_mm;
    if (travel <= 0) return {};
    const int steps = guide_ ? static_cast<int>(guide_->rests.size()) - 1
                             : std::max(10, static_cast<int>(std::ceil(travel / step_mm_)));
    for (int k = 1; k <= steps; ++k) {
      VACUFORM_CHECK(context_.step(Stage::forming, begin_ + (end_ - begin_) * (k - 1) / steps));
      const double frame = k == steps ? machine_.drape_height_mm : start - travel * k / steps;
      Load to;
      to.frame_mm = frame;
      to.seconds = (start - frame) / machine_.drape_speed_mm_s;
      to.contact = double(k) / steps;
      VACUFORM_CHECK(lower(to, guide_ ? guided(k) : extrapolated(k == 1 ? 0 : 1)));
      if (rests_) rests_->push_back(x_);
      ++state_.summary.drape_steps;
    }
    return {};
  }

  // One step of the frame, from a first guess.
  Result<void> lower(const Load& to, Points y) {
    const bool first = now_.seconds == 0 && !guide_;
    for (std::size_t i = 0; i < grid_.clamped.size(); ++i)
      if (grid_.clamped[i] || (first && !state_.held[i])) y(2, i) += to.frame_mm - now_.frame_mm;
    const double load = weight(to.seconds - now_.seconds);
    const double tension = drape_force * spacing_ * viscous_share(to.frame_mm - now_.frame_mm);
    const double force = load > 0 ? std::min(tension, ramp_force * load * spacing_ * spacing_) : tension;
    // The stiffness is computed where the sheet last rested: in the guess it still has a kink at the frame.
    equilibrium_.hold(state_.held, viscous_ ? y : x_, viscous_);
    // The first steps pull an almost flat sheet, which has almost no stiffness against its own plane. They need not
    // converge: the steps that follow even out the remaining error.
    const double still = drape_still_mm * viscous_share(to.frame_mm - now_.frame_mm);
    const Equilibrium::Limits limits{force, still, stride(), unlimited, viscous_ ? 300 : 60};
    VACUFORM_CHECK(solve(y, to, to.seconds - now_.seconds, limits));
    VACUFORM_CHECK(touch(y, state_.landings(process_, y), 1, to, limits));
    go_on(std::move(y), to);
    return {};
  }

  // The vacuum ramps from zero to its limit. Under it a viscous sheet flows until it rests or the hold is over.
  Result<void> draw() {
    const double ramp = machine_.vacuum_seconds, hold = flows_ ? hold_ramps * ramp : ramp;
    const double first = std::min(ramp, first_vacuum_s());
    double growth = most_growth_, grown = 1;  // of the time under vacuum: allowed, and in the last advance
    now_.contact = 1;
    double next = first;
    for (int step = 0; step < most_steps; ++step) {
      next = std::min({hold, next, now_.vacuum_s + longest_step()});
      const bool last = next >= hold;
      VACUFORM_CHECK(context_.step(Stage::forming,
                                   end_ + (1 - end_) * std::log(next / first) / std::log(hold / first + 1)));
      Load to = at_vacuum(next);
      const double dt = to.seconds - now_.seconds, p = pressure(to, dt), cell = spacing_ * spacing_;
      Points y =
          extrapolated(grown > 1.0001 ? std::min(2.0, std::log(next / now_.vacuum_s) / std::log(grown)) : 0);
      equilibrium_.hold(state_.held, y, flows_);
      const double force =
          last ? final_force * p * cell : std::max(ramp_force * p * cell, 0.01 * drape_force * spacing_);
      VACUFORM_TRY(outcome, solve(y, to, dt,
                                  {force, last ? 0 : still_mm, stride(), std::max(6.0, 4 * spacing_), 300}));
      ++state_.summary.vacuum_steps;
      if (outcome.ran_away && growth > 1.02 && now_.vacuum_s > 0) {
        growth = std::sqrt(growth);
        next = growth * now_.vacuum_s;
        continue;
      }

      const double moved = std::sqrt((y - x_).colwise().squaredNorm().maxCoeff());
      double part = 0.5 * spacing_ / std::max(moved, 1e-9);
      const auto landings = state_.landings(process_, y, &*ceiling_);
      if (!outcome.ran_away) part = std::min(1.0, std::max(part, spread_.one_row(state_, landings)));
      if (part < 1) {
        y = x_ + part * (y - x_);
        // Past a limit point the vacuum waits for the sheet.
        to = at_vacuum(outcome.ran_away ? std::max(now_.vacuum_s, first)
                                        : now_.vacuum_s + part * (next - now_.vacuum_s));
      }
      VACUFORM_TRY(touched, touch(y, landings, part, to,
                                  {force, last ? 0 : still_mm, stride(), std::max(6.0, 4 * spacing_), 300}));
      grown = now_.vacuum_s > 0 ? to.vacuum_s / now_.vacuum_s : 1;
      const bool settled = part >= 1 && outcome.at_rest, resting = settled && touched == 0;
      if (flows_ ? (settled && last) || (resting && to.vacuum_s >= ramp && moved < still_mm)
                 : resting && last) {
        x_ = std::move(y);
        balance(to, dt);
        state_.summary.converged = true;
        return {};
      }
      go_on(std::move(y), to);
      if (!outcome.at_rest || (last && part >= 1)) continue;
      growth = std::clamp(std::pow(growth, part < 1 ? 1.1 * part : 1.5), least_growth, most_growth_);
      next = growth * now_.vacuum_s;
    }
    return fail(Code::forming_failed, "the sheet did not come to rest under the vacuum", "forming",
                "try another sheet.resolution_mm, or a lower machine.vacuum_kpa");
  }

  Load at_vacuum(double seconds) const {
    Load to = now_;
    to.seconds += seconds - now_.vacuum_s;
    to.vacuum_s = seconds;
    const double ramp = machine_.vacuum_seconds;
    to.contact = 1 + std::min(1.0, seconds / ramp);
    return to;
  }

  // The modulus used as unit of force, kPa: that of the sheet, or that of a viscous sheet over dt.
  double modulus(double dt) const {
    return viscous_ && dt > 0 ? process_.viscosity_kpa_s / dt : process_.modulus_kpa;
  }
  // In the units of Membrane.
  double pressure(const Load& at, double dt) const {
    const double kpa = machine_.vacuum_kpa * std::min(1.0, at.vacuum_s / machine_.vacuum_seconds);
    return kpa / (modulus(dt) * process_.sheet.thickness_mm);
  }
  // Of a square millimetre of the flat sheet, also in the units of Membrane.
  double weight(double dt) const {
    if (!process_.forming.sag) return 0;
    return 1e-6 * material_profile(process_.sheet.material).density_kg_m3 * gravity_m_s2 / modulus(dt);
  }
  // When the vacuum first has an effect.
  double first_vacuum_s() const {
    const double part = 0.1 / machine_.window_width_mm * process_.modulus_kpa * process_.sheet.thickness_mm /
                        machine_.vacuum_kpa;
    return std::min(1.0, part) * machine_.vacuum_seconds;
  }
  // A viscous sheet carries the strain of one step only and keeps any error at the end of a step. So its tolerance is a
  // share of that of an elastic sheet: the strain that the step causes in a film as long as a quarter of the window.
  double viscous_share(double step_mm) const {
    return viscous_ ? std::min(1.0, std::abs(step_mm) / (0.25 * machine_.window_width_mm)) : 1;
  }
  double stride() const { return std::max(2.0, 1.5 * spacing_); }
  // A sheet that yields must not relax by much within one step.
  double longest_step() const {
    return flows_ && !viscous_ ? 0.3 * process_.viscosity_kpa_s / process_.modulus_kpa : unlimited;
  }

  Result<Equilibrium::Outcome> solve(Points& y, const Load& at, double dt,
                                     const Equilibrium::Limits& limits) {
    const auto outcome = equilibrium_.solve(y, {pressure(at, dt), weight(dt)}, limits, context_);
    state_.summary.iterations += outcome.iterations;
    if (context_.cancelled()) return fail(Code::cancelled, "cancelled");
    return outcome;
  }

  // The free sheet repeats its motion of the last advance, times a ratio.
  Points extrapolated(double ratio) const {
    Points y = x_;
    for (std::size_t i = 0; i < state_.held.size(); ++i)
      if (!state_.held[i]) y.col(i) += ratio * (x_.col(i) - before_.col(i));
    return y;
  }
  // The free sheet moves as the coarser one did in this step.
  Points guided(int step) const {
    Points y = x_;
    const Points moved = guide_->rests[step] - guide_->rests[step - 1];
    for (std::size_t i = 0; i < state_.held.size(); ++i)
      if (!state_.held[i]) y.col(i) += interpolation_->at(moved, i);
    return y;
  }

  // Holds the vertices that land within the first part of the way from x_, at whose end y is; returns their number. A
  // sheet that flows would keep the kinks that this leaves next to them, so it is brought to rest again before it flows.
  Result<int> touch(Points& y, const std::vector<SheetState::Landing>& landings, double part, const Load& to,
                    const Equilibrium::Limits& limits) {
    int touched = state_.land(landings, part, y, now_.contact, to.contact) + meet_points(y, to);
    constexpr int most_rounds = 4;
    for (int round = 0, now = touched; flows_ && now > 0 && round < most_rounds; ++round) {
      equilibrium_.hold(state_.held, y, true);
      VACUFORM_CHECK(solve(y, to, to.seconds - now_.seconds, limits));
      now = state_.land(state_.landings(process_, y, ceiling_ ? &*ceiling_ : nullptr), 1, y, now_.contact,
                        to.contact) +
            meet_points(y, to);
      touched += now;
    }
    return touched;
  }

  // Lets the sharp places of the mold hold the sheet; returns how many triangles this changes.
  int meet_points(Points& y, const Load& to) {
    const std::vector<int> changed = points_.follow(process_, state_, y, now_.contact, to.contact);
    for (const int k : changed) membrane_.reshape(k, state_.rest);
    if (!changed.empty()) equilibrium_.weigh();
    return static_cast<int>(changed.size());
  }

  void go_on(Points&& y, const Load& to) {
    before_ = std::move(x_);
    x_ = std::move(y);
    if (flows_) flow(to.seconds - now_.seconds);
    now_ = to;
  }
  void flow(double dt) {
    const double yield = process_.forming.yield_kpa / process_.modulus_kpa;
    for (int k = 0; k < static_cast<int>(grid_.triangles.size()); ++k) {
      const Triangle& t = grid_.triangles[k];
      if (state_.held[t[0]] && state_.held[t[1]] && state_.held[t[2]]) continue;
      if (viscous_) {
        membrane_.flow(x_, k, 0);
      } else if (const double stress = membrane_.equivalent_stress(x_, k); stress > yield) {
        // A Maxwell element above its yield stress: the excess decays with the time viscosity / modulus.
        const double rate =
            process_.modulus_kpa * process_.stiffness[k] / (process_.viscosity_kpa_s * process_.viscosity[k]);
        const double left = yield + (stress - yield) * std::exp(-rate * dt);
        membrane_.flow(x_, k, membrane_.kept_at_stress(x_, k, left));
      }
    }
  }

  // The remaining imbalance, and the forces on the supports.
  void balance(const Load& at, double dt) {
    const double p = pressure(at, dt);
    Points force(3, x_.cols());
    membrane_.energy(x_, p, force);
    double support = 0, largest_free = 0, projected = 0;
    for (std::size_t i = 0; i < state_.held.size(); ++i)
      if (state_.held[i])
        support += force(2, i);
      else
        largest_free = std::max(largest_free, (force.col(i) + equilibrium_.weight_of(i, weight(dt))).norm());
    for (const Triangle& t : grid_.triangles) {
      const Eigen::Vector2d a = x_.col(t[0]).head<2>(), b = x_.col(t[1]).head<2>() - a,
                            c = x_.col(t[2]).head<2>() - a;
      projected += 0.5 * cross(b, c);
    }
    state_.summary.residual = largest_free / (p * spacing_ * spacing_);
    state_.summary.force_error = std::abs(support / (p * projected) - 1);
    state_.summary.pressure_kpa = machine_.vacuum_kpa;
  }

  // Tolerances of the imbalance, relative to the tension of a unit stretch while draping, and to pressure times the
  // area of a cell on the ramp and at its end.
  static constexpr double drape_force = 1e-2, ramp_force = 1e-2, final_force = 1e-4;
  static constexpr double still_mm =
      0.01;  // a sheet that moves less in an iteration is at rest, but at the end
  static constexpr double drape_still_mm = 0.03;  // the same while the frame descends
  static constexpr double least_growth = 1.003;   // of the time under vacuum, per advance
  static constexpr double hold_ramps =
      10;  // a sheet that flows is held under vacuum for this many times the ramp
  static constexpr int most_steps = 3000;

  const Process& process_;
  const MachineSettings& machine_;
  const SheetGrid& grid_;
  const bool flows_, viscous_;  // viscoplastic; without a yield stress
  Membrane membrane_;
  Equilibrium equilibrium_;
  Context context_;
  const double step_mm_;
  const double most_growth_;  // of the time under vacuum, per advance
  const double begin_, end_;
  const Draped* guide_;
  std::optional<Interpolation> interpolation_;
  std::optional<std::vector<Points>> rests_;  // for a finer sheet to follow
  SheetState& state_;
  Points& x_;
  Points before_;  // the sheet before the last advance
  double spacing_;
  Load now_;
  ContactSpread spread_;
  PointContact points_;
  // The draped sheet: the vacuum pulls it down from there, so no part of it ever comes through from below.
  std::optional<SheetAsObstacle> ceiling_;
};

}  // namespace

Result<void> form_membrane(const Process& process, SheetState& state, const Context& context) {
  // Share of the whole work up to the end of the descent.
  constexpr double coarse_share = 0.05, fine_share = 0.5;
  // Two thirds of a grid spacing: then the error of the step is below that of the grid (bench_exact).
  const double step_mm = process.step_share * process.forming.step_mm.value_or(
                                                  std::clamp(process.sheet.resolution_mm / 1.5, 0.25, 4.0));
  std::vector<std::unique_ptr<Process>> coarser;
  std::optional<Draped> guide;
  double done = 0;
  for (double spacing : {4 * process.sheet.resolution_mm, 2 * process.sheet.resolution_mm}) {
    constexpr double coarsest_mm = 8;  // coarser grids give little information
    if (spacing > coarsest_mm) continue;
    coarser.push_back(std::make_unique<Process>(process.on_grid(spacing)));
    SheetState draped(*coarser.back());
    VACUFORM_TRY(rests, Descent(*coarser.back(), draped, guide ? &*guide : nullptr, step_mm, done,
                                done + coarse_share, context)
                            .drape());
    if (rests.rests.size() > 1) guide.emplace(std::move(rests));
    done += coarse_share;
  }
  return Descent(process, state, guide ? &*guide : nullptr, step_mm, done, fine_share, context).run();
}

}  // namespace vacuform
