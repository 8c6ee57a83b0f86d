// The process: the clamped sheet descends over the mold, then the vacuum draws it down until everything rests.
//
// Quasi-static: after every small advance of the frame or of the pressure the free sheet is brought to rest, the
// straight way of each free vertex is followed to its first touch, what touched sticks there for good, and the rest
// is brought to rest again. An advance of pressure moves no vertex further than a part of the grid spacing before
// contact is looked for, so the sheet follows a path even where a bubble snaps through.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "worker/forming/contact.hpp"
#include "worker/forming/equilibrium.hpp"
#include "worker/forming/findings.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/material.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform {

namespace {

constexpr double never = std::numeric_limits<double>::quiet_NaN();

class Process {
 public:
  Process(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
          const FormingSettings& settings, const Context& context)
      : sheet_(sheet),
        machine_(machine),
        grid_(make_sheet_grid(sheet, machine)),
        obstacles_(mold.mesh, machine),
        membrane_(grid_.rest, grid_.triangles, settings.law),
        equilibrium_(membrane_, grid_.triangles, grid_.elimination_order),
        context_(context),
        top_(mold.top.z()),
        held_(grid_.clamped),
        contact_(grid_.rest.size(), Contact::free),
        time_(grid_.rest.size(), never),
        folded_(grid_.rest.size(), 0),
        x_(3, static_cast<Eigen::Index>(grid_.rest.size())) {
    for (std::size_t i = 0; i < grid_.rest.size(); ++i) {
      x_.col(i) << grid_.rest[i], top_;
      if (grid_.clamped[i]) contact_[i] = Contact::clamp;
    }
  }

  Result<FormedSheet> run() {
    VACUFORM_CHECK(drape());
    VACUFORM_CHECK(draw());
    return finish();
  }

 private:
  // Follows every free vertex from x_ to y; what touches is put there, held, and stamped with its time.
  int touch(Points& y, double from_time, double to_time) {
    int touched = 0;
    std::optional<SheetAsObstacle> itself;
    if (ceiling_ && SheetAsObstacle::possible(y, grid_.triangles, held_)) itself.emplace(x_, grid_.triangles);
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (held_[i]) continue;
      const auto hit = obstacles_.first_touch(x_.col(i), y.col(i));
      auto fold = itself ? itself->stops(x_.col(i), y.col(i)) : std::nullopt;
      if (itself && !fold) fold = ceiling_->stops(x_.col(i), y.col(i));
      if (!hit && !fold) continue;
      if (hit && (!fold || hit->t <= *fold)) {
        y.col(i) = hit->place;
        contact_[i] = hit->with;
        time_[i] = from_time + hit->t * (to_time - from_time);
      } else {  // it touches nothing but itself
        y.col(i) = x_.col(i) + *fold * (y.col(i) - x_.col(i));
        folded_[i] = 1;
      }
      held_[i] = 1;
      ++touched;
    }
    return touched;
  }

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
        again = touch(y, double(k - 1) / steps, double(k) / steps) > 0;
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
    const double modulus = summary_.shear_modulus_kpa = material_profile(sheet_.material).shear_modulus_kpa;
    const double limit = machine_.vacuum_kpa / (modulus * sheet_.thickness_mm);
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
      const int touched = touch(y, now, now);
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

  FormedSheet finish() {
    FormedSheet out;
    out.triangles = grid_.triangles;
    out.rest = grid_.rest;
    out.contact = contact_;
    out.contact_time = time_;
    const std::size_t n = grid_.rest.size();
    out.temperature.assign(n, material_profile(sheet_.material).forming_celsius);
    for (std::size_t i = 0; i < n; ++i) out.formed.push_back(x_.col(i));

    std::vector<double> area(n, 0), volume(n, 0);
    double total_area = 0, total_volume = 0, projected = 0;
    for (std::size_t k = 0; k < out.triangles.size(); ++k) {
      const Triangle& t = out.triangles[k];
      // A triangle that a fold has crushed to a line would be infinitely thick.
      const double stretch = std::max(1e-6, membrane_.area_stretch(x_, static_cast<int>(k)));
      const double thickness = sheet_.thickness_mm / stretch;
      const Eigen::Vector3d normal =
          0.5 * (out.formed[t[1]] - out.formed[t[0]]).cross(out.formed[t[2]] - out.formed[t[0]]);
      out.element_thickness.push_back(thickness);
      const bool folded = folded_[t[0]] || folded_[t[1]] || folded_[t[2]];
      out.element_slack.push_back(folded || membrane_.slack(x_, static_cast<int>(k)));
      total_area += membrane_.rest_area(static_cast<int>(k));
      total_volume += normal.norm() * thickness;
      projected += normal.z();
      for (int v : t) area[v] += normal.norm(), volume[v] += normal.norm() * thickness;
    }
    for (std::size_t i = 0; i < n; ++i)
      out.thickness.push_back(area[i] > 0 ? volume[i] / area[i] : sheet_.thickness_mm);

    Points force(3, x_.cols());
    membrane_.energy(x_, pressure_, force);
    double support = 0, largest_free = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (held_[i])
        support += force(2, i);
      else
        largest_free = std::max(largest_free, force.col(i).norm());
    summary_.residual = largest_free / (pressure_ * sheet_.resolution_mm * sheet_.resolution_mm);
    summary_.mass_error = std::abs(total_volume / (total_area * sheet_.thickness_mm) - 1);
    summary_.force_error = std::abs(support / (pressure_ * projected) - 1);
    summary_.pressure_kpa = pressure_ * summary_.shear_modulus_kpa * sheet_.thickness_mm;
    out.summary = summary_;
    out.warnings = forming_findings(out, sheet_.thickness_mm);
    return out;
  }

  // Out-of-balance forces, against the tension of a unit stretch while draping and against pressure times the
  // area of a cell on the ramp and at its end.
  static constexpr double drape_tolerance = 1e-3, ramp_tolerance = 1e-2, final_tolerance = 1e-4;
  static constexpr double ramp_growth = 1.3;  // of the pressure, a step
  static constexpr int most_steps = 3000;

  SheetSettings sheet_;
  MachineSettings machine_;
  SheetGrid grid_;
  Obstacles obstacles_;
  Membrane membrane_;
  Equilibrium equilibrium_;
  Context context_;
  double top_;
  std::vector<char> held_;
  std::vector<Contact> contact_;
  std::vector<double> time_;
  std::vector<char> folded_;  // held by another part of the sheet
  // The sheet as draped: the vacuum pulls it down from there, so no part of it ever comes through from below.
  std::optional<SheetAsObstacle> ceiling_;
  Points x_;
  double pressure_ = 0;
  FormingSummary summary_;
};

}  // namespace

Result<FormedSheet> form(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
                         const FormingSettings& settings, const Context& context) {
  return Process(mold, sheet, machine, settings, context).run();
}

}  // namespace vacuform
