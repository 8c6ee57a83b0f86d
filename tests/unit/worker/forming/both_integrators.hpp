// The mass-spring model by either integrator: both come to the same rest.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform {

inline const TemperatureField warm(140);

struct Machine {
  SheetSettings sheet;
  MachineSettings machine;
  FormingSettings forming;
};

inline Machine round_machine(double window, double resolution) {
  Machine m;
  m.machine.window = WindowShape::circle;
  m.machine.window_width_mm = window;
  m.sheet.width_mm = m.sheet.height_mm = window + 2 * resolution;
  m.sheet.resolution_mm = resolution;
  m.forming.model = FormingModel::mass_spring;
  return m;
}

// Coarse, for heads.
inline Machine head_machine() {
  Machine m;
  m.sheet.resolution_mm = 8;
  m.forming.model = FormingModel::mass_spring;
  return m;
}

inline Result<FormedSheet> formed_by(const Mold& mold, Machine m, Integrator integrator) {
  m.forming.integrator = integrator;
  return form(mold, m.sheet, m.machine, m.forming, warm, Context{});
}

// The vertices that the simulation moves. Those that a formed sheet gets on rims differ with it.
inline std::size_t grid_vertices(const Machine& m) { return make_sheet_grid(m.sheet, m.machine).rest.size(); }

// The same rest by both integrators: largest distance of any vertex, mm.
inline double apart(const Mold& mold, const Machine& m) {
  const auto a = formed_by(mold, m, Integrator::implicit_euler), b = formed_by(mold, m, Integrator::verlet);
  EXPECT_TRUE(a && b) << (a ? b : a).error().text();
  if (!a || !b) return 1e9;
  double most = 0;
  for (std::size_t i = 0; i < grid_vertices(m); ++i)
    most = std::max(most, (a->formed[i] - b->formed[i]).norm());
  for (const auto* f : {&*a, &*b}) {
    EXPECT_TRUE(f->summary.converged);
    EXPECT_LT(f->summary.residual, 1e-4);
    EXPECT_LT(f->summary.kinetic_mj, 1e-3);
    EXPECT_LT(f->summary.force_error, 1e-5);
    EXPECT_LT(f->summary.mass_error, 1e-9);
    EXPECT_NEAR(f->summary.pressure_kpa, 85, 1e-9);
  }
  return most;
}

}  // namespace vacuform
