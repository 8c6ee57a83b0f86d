#include "worker/forming/process.hpp"

#include <cmath>
#include <limits>

#include "worker/forming/material.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

double nearness_to_frame(const Eigen::Vector2d& rest, const MachineSettings& machine) {
  const auto square = [](double v) { return v * v; };
  const double x = square(2 * rest.x() / machine.window_width_mm);
  if (machine.window == WindowShape::circle)
    return std::min(1.0, x + square(2 * rest.y() / machine.window_width_mm));
  const double y = square(2 * rest.y() / machine.window_height_mm);
  return 1 - std::max(0.0, 1 - x) * std::max(0.0, 1 - y);
}

Process::Process(const Obstacles& around, double top, const SheetSettings& of_sheet,
                 const MachineSettings& on_machine, const FormingSettings& by_forming,
                 const TemperatureField& at_temperature)
    : obstacles(around),
      top_mm(top),
      sheet(of_sheet),
      machine(on_machine),
      forming(by_forming),
      temperature(at_temperature),
      grid(make_sheet_grid(of_sheet, on_machine)),
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
  Process on_it(obstacles, top_mm, other, machine, forming, temperature);
  on_it.step_share = step_share;
  return on_it;
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

std::vector<SheetState::Landing> SheetState::landings(const Process& process, const Points& y,
                                                      const SheetAsObstacle* ceiling) const {
  std::optional<SheetAsObstacle> itself;
  if (ceiling && SheetAsObstacle::possible(y, process.grid.triangles, held))
    itself.emplace(x, process.grid.triangles);
  constexpr int parts = 64;
  std::vector<std::vector<Landing>> found(parts);
  const auto look = [&](int part) {
    const std::size_t begin = held.size() * part / parts, end = held.size() * (part + 1) / parts;
    for (std::size_t i = begin; i < end; ++i) {
      if (held[i]) continue;
      const auto hit = process.obstacles.first_touch(x.col(i), y.col(i));
      auto fold = itself ? itself->stops(x.col(i), y.col(i)) : std::nullopt;
      if (itself && !fold) fold = ceiling->stops(x.col(i), y.col(i));
      if (hit && (!fold || hit->t <= *fold))
        found[part].push_back({static_cast<int>(i), hit->t, hit->place, hit->with});
      else if (fold)  // it touches nothing but itself
        found[part].push_back(
            {static_cast<int>(i), *fold, x.col(i) + *fold * (y.col(i) - x.col(i)), Contact::free});
    }
  };
  in_parallel(0, parts, [&](int begin, int end) {
    for (int part = begin; part < end; ++part) look(part);
  });
  std::vector<Landing> all;
  for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
  return all;
}

int SheetState::land(const std::vector<Landing>& landings, double part, Points& y, double from_time,
                     double to_time) {
  int landed = 0;
  for (const Landing& landing : landings) {
    if (landing.part > part) continue;
    const int i = landing.vertex;
    y.col(i) = landing.place;
    held[i] = 1;
    if (landing.with == Contact::free) {
      folded[i] = 1;
    } else {
      contact[i] = landing.with;
      time[i] = from_time + landing.part / part * (to_time - from_time);
    }
    ++landed;
  }
  return landed;
}

}  // namespace vacuform
