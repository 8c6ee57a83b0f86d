#include "worker/forming/process.hpp"

#include <cmath>
#include <limits>

#include "worker/forming/material.hpp"

namespace vacuform {

double nearness_to_frame(const Eigen::Vector2d& rest, const MachineSettings& machine) {
  const auto square = [](double v) { return v * v; };
  const double x = square(2 * rest.x() / machine.window_width_mm);
  if (machine.window == WindowShape::circle)
    return std::min(1.0, x + square(2 * rest.y() / machine.window_width_mm));
  const double y = square(2 * rest.y() / machine.window_height_mm);
  return 1 - std::max(0.0, 1 - x) * std::max(0.0, 1 - y);
}

Process::Process(const Obstacles& obstacles_, double top, const SheetSettings& sheet_,
                 const MachineSettings& machine_, const FormingSettings& forming_,
                 const TemperatureField& temperature_)
    : obstacles(obstacles_),
      top_mm(top),
      sheet(sheet_),
      machine(machine_),
      forming(forming_),
      temperature(temperature_),
      grid(make_sheet_grid(sheet_, machine_)),
      modulus_kpa(shear_modulus_kpa(sheet.material, temperature.at({0, 0}))),
      viscosity_kpa_s(1e-3 * viscosity_pa_s(sheet.material, temperature.at({0, 0}))) {
  for (const auto& rest : grid.rest) celsius.push_back(temperature.at(rest));
  for (const Triangle& t : grid.triangles) {
    const Eigen::Vector2d middle = (grid.rest[t[0]] + grid.rest[t[1]] + grid.rest[t[2]]) / 3;
    const double celsius_here = temperature.at(middle);
    const double edge = 1 + (forming.edge_stiffness - 1) * nearness_to_frame(middle, machine);
    stiffness.push_back(edge * shear_modulus_kpa(sheet.material, celsius_here) / modulus_kpa);
    viscosity.push_back(edge * 1e-3 * viscosity_pa_s(sheet.material, celsius_here) / viscosity_kpa_s);
  }
}

Process Process::on_grid(double resolution_mm) const {
  SheetSettings other = sheet;
  other.resolution_mm = resolution_mm;
  return {obstacles, top_mm, other, machine, forming, temperature};
}

SheetState::SheetState(const Process& process)
    : rest(process.grid.rest),
      x(3, static_cast<Eigen::Index>(process.grid.rest.size())),
      held(process.grid.clamped),
      contact(process.grid.rest.size(), Contact::free),
      time(process.grid.rest.size(), std::numeric_limits<double>::quiet_NaN()),
      folded(process.grid.rest.size(), 0) {
  for (std::size_t i = 0; i < held.size(); ++i) {
    x.col(i) << process.grid.rest[i], process.top_mm;
    if (held[i]) contact[i] = Contact::clamp;
  }
}

int SheetState::follow(const Process& process, Points& y, double from_time, double to_time,
                       const SheetAsObstacle* ceiling) {
  int touched = 0;
  std::optional<SheetAsObstacle> itself;
  if (ceiling && SheetAsObstacle::possible(y, process.grid.triangles, held))
    itself.emplace(x, process.grid.triangles);
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i]) continue;
    const auto hit = process.obstacles.first_touch(x.col(i), y.col(i));
    auto fold = itself ? itself->stops(x.col(i), y.col(i)) : std::nullopt;
    if (itself && !fold) fold = ceiling->stops(x.col(i), y.col(i));
    if (!hit && !fold) continue;
    if (hit && (!fold || hit->t <= *fold)) {
      y.col(i) = hit->place;
      contact[i] = hit->with;
      time[i] = from_time + hit->t * (to_time - from_time);
    } else {  // it touches nothing but itself
      y.col(i) = x.col(i) + *fold * (y.col(i) - x.col(i));
      folded[i] = 1;
    }
    held[i] = 1;
    ++touched;
  }
  return touched;
}

}  // namespace vacuform
