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
#include "worker/scan/smoothing.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {

namespace {
// That the mold may stand out of the sheet at a rim without a vertex there: in a scan, what else is reported as pierced.
constexpr double model_rim_mm = 0.04, scan_rim_mm = FitLimits().pierced_mm;

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

// Sets the thickness at the vertices from that of the triangles.
void set_thickness(FormedSheet& sheet, double where_nothing_is_left_mm) {
  std::vector<double> area(sheet.formed.size(), 0), volume(area);
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    const double formed = formed_area(sheet, sheet.triangles[k]);
    for (const int v : sheet.triangles[k])
      area[v] += formed, volume[v] += formed * sheet.element_thickness[k];
  }
  sheet.thickness.clear();
  for (std::size_t v = 0; v < area.size(); ++v)
    sheet.thickness.push_back(area[v] > 0 ? volume[v] / area[v] : where_nothing_is_left_mm);
}

// What was simulated: one vertex for each of the grid.
FormedSheet sheet_on_grid(const Process& process, SheetState&& state) {
  FormedSheet out;
  out.triangles = process.grid.triangles;
  out.rest = std::move(state.rest);
  out.contact = std::move(state.contact);
  out.contact_time = std::move(state.time);
  out.temperature = process.celsius;
  out.summary = state.summary;
  out.summary.shear_modulus_kpa = process.modulus_kpa;
  const std::size_t n = out.rest.size();
  for (std::size_t i = 0; i < n; ++i) out.formed.push_back(state.x.col(i));

  const Membrane membrane(out.rest, process.grid.triangles, process.forming.law, process.stiffness);
  double total_area = 0, total_volume = 0;
  for (std::size_t k = 0; k < out.triangles.size(); ++k) {
    const Triangle& t = out.triangles[k];
    // A triangle that a fold has crushed to a line would be infinitely thick.
    const double stretch = std::max(1e-6, membrane.area_stretch(state.x, static_cast<int>(k)));
    out.element_thickness.push_back(process.sheet.thickness_mm / stretch);
    const bool folded = state.folded[t[0]] || state.folded[t[1]] || state.folded[t[2]];
    out.element_wrinkled.push_back(folded || membrane.wrinkled(state.x, static_cast<int>(k)));
    total_area += membrane.rest_area(static_cast<int>(k));
    total_volume += formed_area(out, t) * out.element_thickness[k];
  }
  set_thickness(out, process.sheet.thickness_mm);
  out.summary.mass_error = std::abs(total_volume / (total_area * process.sheet.thickness_mm) - 1);
  return out;
}

// The sheet at rest, whole.
Result<FormedSheet> whole_sheet(const Process& process, const Context& context) {
  SheetState state(process);
  VACUFORM_CHECK(form_by_model(process, state, context));
  FormedSheet sheet = sheet_on_grid(process, std::move(state));
  // Who sets the limit of thinness to nothing studies an ideal sheet, which never tears.
  const auto tear = process.forming.thin_limit > 0 ? torn_at(sheet) : std::nullopt;
  if (!tear) return sheet;
  // Forming takes too long to try the other law.
  std::vector<Proposal> proposals;
  if (process.forming.law == MembraneLaw::neo_hookean && process.forming.model == FormingModel::membrane)
    proposals.push_back({{{"forming.law", name(MembraneLaw::mooney_rivlin)}}, ""});
  Error error{Code::forming_failed,
              "the sheet tears: over " + decimal(tear->area_mm2, 0) + " mm2 it is stretched up to " +
                  decimal(tear->stretch, 0) + " times",
              "x = " + decimal(tear->place.x(), 0) + " mm, y = " + decimal(tear->place.y(), 0) +
                  " mm, z = " + decimal(tear->place.z(), 0) + " mm on the mold",
              advice_with(proposals.empty() ? "" : "give another law", proposals,
                          "trim the mold higher (scan.trim_mm), or use a larger window")};
  error.proposals = std::move(proposals);
  error.place_mm = {tear->place.x(), tear->place.y(), tear->place.z()};
  return tl::make_unexpected(std::move(error));
}

// What fails or tears in the usual steps is tried again in half of them: so a tear is one of the sheet, not of the steps.
Result<FormedSheet> whole_sheet_in_two_tries(Process process, const Context& context) {
  auto sheet = whole_sheet(process, context);
  const bool in_steps =
      process.forming.model == FormingModel::membrane || process.forming.model == FormingModel::viscoplastic;
  if (sheet || sheet.error().code != Code::forming_failed || !in_steps) return sheet;
  process.step_share = 0.5;
  sheet = whole_sheet(process, context.silent());  // the progress has been at its end
  if (sheet) sheet->summary.half_steps = true;
  return sheet;
}

FindingLimits limits_of(const Process& process) {
  FindingLimits limits;
  limits.fit.bridged_mm = std::max(0.5, 0.5 * process.sheet.resolution_mm);
  limits.thickness_ratio = process.forming.thin_limit;
  const bool elastic = process.forming.model == FormingModel::membrane;
  if (elastic && process.forming.law == MembraneLaw::neo_hookean) limits.stretch = 3;
  return limits;
}

}  // namespace

Result<FormedSheet> form(const Mold& mold, const SheetSettings& plastic, const MachineSettings& machine,
                         const FormingSettings& settings, const TemperatureField& temperature,
                         const Context& context) {
  SheetSettings sheet = plastic;
  sheet.resolution_mm = grid_spacing_mm(plastic, settings);
  const Obstacles obstacles(mold.mesh, machine);
  const Process process(obstacles, mold.top.z(), sheet, machine, settings, temperature);
  VACUFORM_TRY(on_grid, whole_sheet_in_two_tries(process, context));
  FormedSheet formed = on_grid;
  const double radius = bounds(mold.mesh).size().head<2>().maxCoeff() / 2;
  // A projection moves straight down, also between the vertices.
  if (settings.model != FormingModel::projection) {
    bend_to_mold(formed, obstacles, temperature,
                 has_long_edges(mold.mesh, radius) ? model_rim_mm : scan_rim_mm);
    set_thickness(formed, sheet.thickness_mm);
  }
  FindingLimits limits = limits_of(process);
  limits.rough = is_rough(mold.mesh, radius);
  formed.fit = surface_fit(formed.triangles, formed.formed, formed.contact, mold.mesh, limits.fit);
  // The rest is said of what was simulated.
  on_grid.fit = formed.fit;
  Findings findings = forming_findings(on_grid, mold.mesh, process.sheet.thickness_mm, limits);
  formed.warnings = std::move(findings.warnings);
  formed.vents = std::move(findings.vents);
  return formed;
}

}  // namespace vacuform
