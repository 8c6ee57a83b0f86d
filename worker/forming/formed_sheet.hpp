// The forming stage: a mold and a machine in, the sheet at rest on it out.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/scan/mold.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// What a vertex touches; the wall under the clamp frame's window counts as the clamp.
enum class Contact : std::uint8_t { free = 0, mold = 1, platform = 2, clamp = 3 };

// A hole to drill into the mold, so that trapped air can leave.
struct Vent {
  Eigen::Vector3d place;  // on the mold, mm
  double diameter_mm;
};

// How far the extrapolation from grids of these spacings moves what touches the mold, mm: about the error of the finer.
struct Extrapolation {
  double coarse_mm = 0, fine_mm = 0;
  double mean = 0, p95 = 0, max = 0;
};

// Figures of the simulation, for report.json.
struct FormingSummary {
  int drape_steps = 0, vacuum_steps = 0;
  int iterations = 0;  // of the solver, all steps
  double residual =
      0;  // largest out-of-balance nodal force at the end, over the mean pressure force of a node
  double kinetic_mj = 0;  // energy of the motion that is left (mass_spring); 0 where nothing moves
  bool converged = false;
  bool half_steps = false;       // of frame and vacuum: the usual steps failed or tore the sheet
  double pressure_kpa = 0;       // reached
  double mass_error = 0;         // |volume of plastic now / at first - 1|, summed over the elements
  double force_error = 0;        // |vertical force of the supports / (p times projected area) - 1|
  double shear_modulus_kpa = 0;  // of the material at its forming temperature
  std::optional<Extrapolation>
      extrapolation;  // of a fast forming; the other figures are those of its finer grid
};

// A distance over a surface, mm.
struct Deviation {
  double p99 = 0, max = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the largest
};
// A part of a surface that is too far off the other.
struct Misfit {
  Eigen::Vector3d place;                // where it is furthest
  double distance_mm = 0, size_mm = 0;  // there; twice its reach from there
};
struct SurfaceFit {
  Deviation penetration;                 // of the mold through the sheet
  Deviation gap;                         // between the mold and what touches it
  std::vector<Misfit> pierced, bridged;  // beyond a limit, worst first
};

// The sheet's triangulation: its grid, with more vertices where it bends to the mold (curved_contact.hpp). Arrays over
// vertices have one entry a vertex, over triangles one a triangle.
// Triangles are counter-clockwise seen from above (from the side that faces the ceiling).
struct FormedSheet {
  std::vector<Triangle> triangles;
  std::vector<Eigen::Vector2d> rest;    // sheet coordinates (s, t), mm
  std::vector<Eigen::Vector3d> formed;  // (x, y, z), mm: the face that lies on the mold
  std::vector<double> thickness;        // mm, mean of the triangles around weighted by formed area
  std::vector<double> temperature;      // degrees Celsius
  std::vector<Contact> contact;
  std::vector<double> contact_time;  // 0..1 while the frame descends, 1..2 on the vacuum ramp, NaN: never
  std::vector<double> element_thickness;  // mm, exact by conservation of mass per triangle
  std::vector<std::uint8_t>
      element_wrinkled;  // 1 where the sheet is compressed across its tension, or folds onto itself
  FormingSummary summary;
  SurfaceFit fit;
  std::vector<Vent> vents;  // where air is trapped
  std::vector<Warning> warnings;
};

// The area of a triangle of the sheet once it is formed, mm^2.
inline double formed_area(const FormedSheet& sheet, const Triangle& t) {
  const auto at = [&](std::size_t k) -> const Eigen::Vector3d& { return sheet.formed[t[k]]; };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
}

// Forms the sheet, from the temperature it has when it meets the mold. Pure and deterministic.
// Errors: forming_failed, cancelled.
Result<FormedSheet> form(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
                         const FormingSettings& settings, const TemperatureField& temperature,
                         const Context& context);

}  // namespace vacuform
