// What every model of the sheet works on: the problem, and the state of the sheet on its way to the mold.
#pragma once

#include <optional>
#include <vector>

#include "worker/forming/contact.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// 0 at the sheet's centre, 1 at the clamp frame and beyond, smooth between.
double nearness_to_frame(const Eigen::Vector2d& rest, const MachineSettings& machine);

// The problem. The frame starts level with the mold's top (higher by the sag, where the sheet sags) and descends to
// machine.drape_height_mm; `obstacles` outlives the process.
struct Process {
  Process(const Obstacles& obstacles, double top_mm, const SheetSettings& sheet,
          const MachineSettings& machine, const FormingSettings& forming,
          const TemperatureField& temperature);

  // The same on a grid of another spacing.
  Process on_grid(double resolution_mm) const;

  const Obstacles& obstacles;
  double top_mm;  // height of the mold's highest point
  SheetSettings sheet;
  MachineSettings machine;
  FormingSettings forming;
  TemperatureField temperature;
  SheetGrid grid;
  std::vector<double> celsius;    // per vertex
  std::vector<double> stiffness;  // per triangle: its modulus over modulus_kpa
  std::vector<double> viscosity;  // per triangle: its viscosity over viscosity_kpa_s
  double modulus_kpa;             // shear modulus at the centre of the sheet
  double viscosity_kpa_s;         // shear viscosity there
  double step_share = 1;          // of the usual steps of frame and vacuum
};

// The sheet on its way.
struct SheetState {
  explicit SheetState(const Process& process);  // flat, level with the mold's top, clamped

  // A free vertex that touches something on its way straight from x to y.
  struct Landing {
    int vertex;
    double part;            // of the way, in [0, 1]
    Eigen::Vector3d place;  // there
    Contact with;           // free: the sheet itself
  };
  // All of them, by vertex: what touches an obstacle or, where a ceiling is given, the sheet itself or its ceiling from
  // below.
  std::vector<Landing> landings(const Process& process, const Points& y,
                                const SheetAsObstacle* ceiling = nullptr) const;
  // Holds what lands within the first part of the way, in y at its place, and stamps it with its time between from_time
  // and to_time, which is the end of that part. Returns how many land. x stays.
  int land(const std::vector<Landing>& landings, double part, Points& y, double from_time, double to_time);

  std::vector<Eigen::Vector2d>
      rest;  // the grid's, but for vertices that were moved to sharp places of the mold
  Points x;
  std::vector<char> held;        // clamped, or stuck
  std::vector<Contact> contact;  // what it touches
  std::vector<double> time;      // of contact, as FormedSheet::contact_time
  std::vector<char> folded;      // held by another part of the sheet
  FormingSummary summary;        // all but mass_error and shear_modulus_kpa
};

// The models. Each brings the sheet from flat to formed. Errors: forming_failed, cancelled.
Result<void> form_membrane(const Process& process, SheetState& state,
                           const Context& context);  // and viscoplastic
Result<void> form_extrapolated(const Process& process, SheetState& state,
                               const Context& context);  // the membrane, from coarser grids
Result<void> form_mass_spring(const Process& process, SheetState& state, const Context& context);
Result<void> form_projection(const Process& process, SheetState& state, const Context& context);

}  // namespace vacuform
