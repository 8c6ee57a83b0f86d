// From a mold and a machine to the formed sheet, by the model that is asked for.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "api/base/decimal.hpp"
#include "worker/forming/curved_contact.hpp"
#include "worker/forming/findings.hpp"
#include "worker/forming/process.hpp"
#include "worker/forming/surface_fit.hpp"
#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

Result<void> form_by_model(const Process& process, SheetState& state, const Context& context) {
  if (process.forming.quality == FormingQuality::fast) return form_extrapolated(process, state, context);
  switch (process.forming.model) {
    case FormingModel::membrane:
    case FormingModel::viscoplastic:
      return form_membrane(process, state, context);
    case FormingModel::mass_spring:
      return form_mass_spring(process, state, context);
    case FormingModel::projection:
      return form_projection(process, state, context);
  }
  std::abort();
}

FormedSheet finish(const Process& process, const TriangleMesh& mold, SheetState&& state) {
  FormedSheet out;
  out.triangles = process.grid.triangles;
  out.rest = std::move(state.rest);
  out.contact = std::move(state.contact);
  out.contact_time = std::move(state.time);
  out.temperature = process.celsius;
  out.summary = state.summary;
  out.summary.shear_modulus_kpa = process.modulus_kpa;
  for (Eigen::Index i = 0; i < state.x.cols(); ++i) out.formed.push_back(state.x.col(i));

  const Membrane membrane(out.rest, process.grid.triangles, process.forming.law, process.stiffness);
  for (std::size_t k = 0; k < out.triangles.size(); ++k) {
    const Triangle& t = out.triangles[k];
    const bool folded = state.folded[t[0]] || state.folded[t[1]] || state.folded[t[2]];
    out.element_wrinkled.push_back(folded || membrane.wrinkled(state.x, static_cast<int>(k)));
  }
  if (process.forming.model != FormingModel::projection) bend_to_mold(out, process.obstacles);

  const std::size_t n = out.rest.size();
  std::vector<double> area(n, 0), volume(n, 0);
  double total_volume = 0;
  for (const Triangle& t : out.triangles) {
    const Eigen::Vector2d flat_b = out.rest[t[1]] - out.rest[t[0]], flat_c = out.rest[t[2]] - out.rest[t[0]];
    const double flat = 0.5 * cross(flat_b, flat_c);
    const double formed =
        0.5 * (out.formed[t[1]] - out.formed[t[0]]).cross(out.formed[t[2]] - out.formed[t[0]]).norm();
    // A triangle that a fold has crushed to a line would be infinitely thick.
    const double thickness = process.sheet.thickness_mm / std::max(1e-6, formed / flat);
    out.element_thickness.push_back(thickness);
    total_volume += formed * thickness;
    for (int v : t) area[v] += formed, volume[v] += formed * thickness;
  }
  for (std::size_t i = 0; i < n; ++i)
    out.thickness.push_back(area[i] > 0 ? volume[i] / area[i] : process.sheet.thickness_mm);
  const double volume_before = process.sheet.width_mm * process.sheet.height_mm * process.sheet.thickness_mm;
  out.summary.mass_error = std::abs(total_volume / volume_before - 1);
  FindingLimits limits;
  limits.fit = {std::max(0.5, 0.2 * process.sheet.resolution_mm),
                std::max(0.5, 0.5 * process.sheet.resolution_mm)};
  out.fit = surface_fit(out.triangles, out.formed, out.contact, mold, limits.fit);
  limits.thickness_ratio = process.forming.thin_limit;
  const bool elastic = process.forming.model == FormingModel::membrane;
  if (elastic && process.forming.law == MembraneLaw::neo_hookean) limits.stretch = 3;
  Findings findings = forming_findings(out, mold, process.sheet.thickness_mm, limits);
  out.warnings = std::move(findings.warnings);
  out.vents = std::move(findings.vents);
  return out;
}

}  // namespace

Result<FormedSheet> form(const Mold& mold, const SheetSettings& plastic, const MachineSettings& machine,
                         const FormingSettings& settings, const TemperatureField& temperature,
                         const Context& context) {
  SheetSettings sheet = plastic;
  if (settings.quality == FormingQuality::fine) sheet.resolution_mm /= 2;
  const Obstacles obstacles(mold.mesh, machine);
  const Process process(obstacles, mold.top.z(), sheet, machine, settings, temperature);
  SheetState state(process);
  VACUFORM_CHECK(form_by_model(process, state, context));
  FormedSheet formed = finish(process, mold.mesh, std::move(state));
  // Who sets the limit of thinness to nothing studies an ideal sheet, which never tears.
  const auto tear = settings.thin_limit > 0 ? torn_at(formed) : std::nullopt;
  if (tear) {
    Error error{
        Code::forming_failed,
        "the sheet tears: over " + decimal(tear->area_mm2, 0) + " mm2 it is stretched up to " +
            decimal(tear->stretch, 0) + " times",
        "x = " + decimal(tear->place.x(), 0) + " mm, y = " + decimal(tear->place.y(), 0) +
            " mm, z = " + decimal(tear->place.z(), 0) + " mm on the mold",
        settings.law == MembraneLaw::neo_hookean && settings.model == FormingModel::membrane
            ? "give --set forming.law=mooney_rivlin, trim the mold higher (scan.trim_mm), or use a larger "
              "window"
            : "trim the mold higher (scan.trim_mm), or use a larger window"};
    error.place_mm = {tear->place.x(), tear->place.y(), tear->place.z()};
    return tl::make_unexpected(std::move(error));
  }
  return formed;
}

}  // namespace vacuform
