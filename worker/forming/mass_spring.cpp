// The path of the net of springs: the clamped sheet descends over the mold, then the vacuum draws it down.
//
// The machine is slow compared to the sheet, whose waves cross it in hundredths of a second, so the path is a sequence
// of states of rest. The clock of the machine advances by small increments of the frame and of the pressure. After each
// increment the net is brought to rest, the straight path of every free vertex from the last rest to this one is
// followed to its first contact, and vertices that touch stick there permanently. So only rest positions decide where a
// vertex lands, and any integrator that finds them follows the same path: on the head of a newborn on a 3 mm grid
// Verlet and implicit Euler differ by at most 0.001 mm. Increments of half the size move the sheet on the head by 0.014
// mm on average and by 0.083 mm at most.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "api/base/decimal.hpp"
#include "worker/forming/material.hpp"
#include "worker/forming/process.hpp"
#include "worker/forming/settling.hpp"
#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

constexpr double growth = 1.3;  // of the pressure, per increment

// The state of the machine at the end of each increment.
struct Moment {
  double frame_mm;  // height of the frame
  double vacuum_kpa;
  double contact_time;  // as FormedSheet::contact_time
};

// The frame descends by at most half the grid spacing per increment, and the pressure grows from `first_kpa` by at most
// `growth`.
std::vector<Moment> moments(const Process& process, double top_mm, double first_kpa) {
  const MachineSettings& m = process.machine;
  const double travel = std::max(0.0, top_mm - m.drape_height_mm), landed = travel / m.drape_speed_mm_s;
  const double stride = std::min(0.5 * process.sheet.resolution_mm, travel / 10) / m.drape_speed_mm_s;
  const double end = landed + m.vacuum_seconds;
  const auto pressure = [&](double t) {
    return m.vacuum_kpa * std::clamp((t - landed) / m.vacuum_seconds, 0.0, 1.0);
  };
  const auto reached = [&](double kpa) { return landed + m.vacuum_seconds * kpa / m.vacuum_kpa; };

  std::vector<Moment> all;
  double t = 0;
  while (t < end) {
    double next = end;
    if (t < landed)
      next = std::min(landed, t + stride);
    else if (pressure(t) < m.vacuum_kpa)
      next = std::min(next, std::max(reached(first_kpa), reached(growth * pressure(t))));
    t = next;
    all.push_back({t < landed ? top_mm - m.drape_speed_mm_s * t : top_mm - travel, pressure(t),
                   t < landed ? t / landed : 1 + (t - landed) / (end - landed)});
  }
  return all;
}

class Forming {
 public:
  Forming(const Process& process, SheetState& state, const Context& context)
      : process_(process),
        state_(state),
        context_(context),
        spacing_(process.sheet.resolution_mm),
        // The pressure that begins to bulge the sheet; the imbalance that remains at rest is negligible against it.
        first_kpa_(std::min(
            process.machine.vacuum_kpa,
            0.1 * process.modulus_kpa * process.sheet.thickness_mm / process.machine.window_width_mm)),
        net_(process.grid, process.stiffness, process.sheet.thickness_mm,
             {3 * process.modulus_kpa * newtons_mm2,
              1e-6 * material_profile(process.sheet.material).density_kg_m3}),
        settling_(process.forming.integrator, process.forming.time_step_ms,
                  1e-3 * first_kpa_ * newtons_mm2 * spacing_ * spacing_, spacing_ / 4) {
    if (process.forming.sag) load_.gravity = 9.81e-3;
  }

  Result<void> run() {
    VACUFORM_CHECK(sag());
    const double top = state_.x.row(2).maxCoeff();
    const std::vector<Moment> way = moments(process_, top, first_kpa_);
    double from = 0;
    for (std::size_t k = 0; k < way.size(); ++k) {
      done_ = static_cast<double>(k) / static_cast<double>(way.size());
      VACUFORM_TRY(touched, advance(way[k], from));
      from = way[k].contact_time;
      // At the end of the ramp, until new contacts draw nothing more along.
      for (int again = 0; k + 1 == way.size() && touched > 0; ++again) {
        if (again == most_rounds) return no_rest();
        VACUFORM_TRY(more, advance(way[k], from));
        touched = more;
      }
    }
    balance();
    return {};
  }

 private:
  // The sheet sags before it meets anything, and the frame starts higher by the sag.
  Result<void> sag() {
    if (load_.gravity == 0) return {};
    Points y = state_.x;
    VACUFORM_CHECK(settle(y));
    y.row(2).array() += process_.top_mm - y.row(2).minCoeff();
    state_.x = y;
    return {};
  }

  // Advances machine and sheet to this moment; returns how many vertices touched on the way.
  Result<int> advance(const Moment& moment, double from) {
    const bool descends = moment.contact_time <= 1;
    load_.pressure = moment.vacuum_kpa * newtons_mm2;
    if (!descends && !ceiling_) ceiling_.emplace(state_.x, process_.grid.triangles);
    Points y = state_.x;
    for (std::size_t i = 0; i < state_.held.size(); ++i)
      if (process_.grid.clamped[i])
        y(2, i) = moment.frame_mm;
      else if (descends && !state_.held[i])
        y.col(i) = guess(i, moment);
    VACUFORM_CHECK(settle(y));
    const int touched = state_.land(state_.landings(process_, y, ceiling_ ? &*ceiling_ : nullptr), 1, y, from,
                                    moment.contact_time);
    before_ = state_.x;
    state_.x = y;
    ++(descends ? state_.summary.drape_steps : state_.summary.vacuum_steps);
    return touched;
  }

  // The free sheet continues its last motion; at first all of it moves with the frame.
  Eigen::Vector3d guess(std::size_t i, const Moment& moment) const {
    if (state_.summary.drape_steps > 0) return 2 * state_.x.col(i) - before_.col(i);
    return state_.x.col(i) - Eigen::Vector3d(0, 0, state_.x.row(2).maxCoeff() - moment.frame_mm);
  }

  // Brings the free vertices of y to rest.
  Result<void> settle(Points& y) {
    VACUFORM_CHECK(context_.step(Stage::forming, done_));
    const SpringNet part = net_.part(state_.held);
    Points x(3, part.vertices());
    for (int i = 0; i < part.vertices(); ++i) x.col(i) = y.col(part.in_sheet()[i]);
    VACUFORM_TRY(outcome, settling_.settle(part, x, load_, context_, done_));
    if (outcome.blew_up) return blew_up(outcome);
    state_.summary.iterations += outcome.steps;
    state_.summary.kinetic_mj = outcome.kinetic;
    if (!outcome.at_rest) return no_rest();
    for (int i = 0; i < part.moving(); ++i) y.col(part.in_sheet()[i]) = x.col(i);
    return {};
  }

  tl::unexpected<Error> blew_up(const Settling::Outcome& outcome) const {
    return fail(
        Code::forming_failed,
        std::string("the net of springs blows up with time steps of ") + decimal(outcome.step_ms, 3) + " ms",
        "forming.time_step_ms", "give a shorter one or auto, or set forming.integrator to implicit_euler");
  }
  static tl::unexpected<Error> no_rest() {
    return fail(
        Code::forming_failed, "the net of springs did not come to rest", "forming",
        "try another sheet.resolution_mm, a lower machine.vacuum_kpa, or forming.time_step_ms = auto");
  }

  // The remaining imbalance, and the forces on the supports.
  void balance() {
    Points f;
    net_.forces(state_.x, Points::Zero(3, state_.x.cols()), load_.pressure, load_.gravity, f);
    double support = 0, largest = 0, projected = 0, mass = 0;
    for (double m : net_.mass()) mass += m;
    for (std::size_t i = 0; i < state_.held.size(); ++i)
      if (state_.held[i])
        support -= f(2, i);
      else
        largest = std::max(largest, f.col(i).norm());
    for (const Triangle& t : process_.grid.triangles) {
      const Eigen::Vector2d a = state_.x.col(t[0]).head<2>(), b = state_.x.col(t[1]).head<2>() - a,
                            c = state_.x.col(t[2]).head<2>() - a;
      projected += 0.5 * cross(b, c);
    }
    FormingSummary& s = state_.summary;
    s.converged = true;
    s.residual = largest / (load_.pressure * spacing_ * spacing_);
    s.force_error = std::abs(support / (load_.pressure * projected + load_.gravity * mass) - 1);
    s.pressure_kpa = load_.pressure / newtons_mm2;
  }

  static constexpr double newtons_mm2 = 1e-3;  // per kPa
  static constexpr int most_rounds = 1000;

  const Process& process_;
  SheetState& state_;
  Context context_;
  double spacing_, first_kpa_;
  SpringNet net_;
  Settling settling_;
  Load load_;
  Points before_;
  double done_ = 0;
  // The draped sheet: the vacuum pulls it down from there, so no part of it ever comes through from below.
  std::optional<SheetAsObstacle> ceiling_;
};

}  // namespace

Result<void> form_mass_spring(const Process& process, SheetState& state, const Context& context) {
  return Forming(process, state, context).run();
}

}  // namespace vacuform
