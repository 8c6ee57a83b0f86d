#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "worker/colour/ink_curve.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/forming/material.hpp"
#include "worker/inspection/circuits_json.hpp"
#include "worker/inspection/coil_json.hpp"
#include "worker/inspection/heat_maps.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/json_numbers.hpp"
#include "worker/inspection/segments_json.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/scan/findings_json.hpp"
#include "worker/stage/warning_json.hpp"

namespace vacuform {
namespace {

using Json = nlohmann::ordered_json;

Json deviation_of(const Deviation& d) {
  return {{"p99", rounded(d.p99, 4)}, {"max", rounded(d.max, 4)}, {"place_mm", array(d.place, 1)}};
}

Json forming_of(const Finished& job) {
  const FormedSheet& sheet = job.sheet;
  std::array<std::int64_t, 4> counts{};
  double gap = 0;  // at the vertices: what the solver left, where the surfaces differ by the grid as well
  for (std::size_t i = 0; i < sheet.contact.size(); ++i) {
    ++counts[static_cast<std::size_t>(sheet.contact[i])];
    if (sheet.contact[i] == Contact::mold) gap = std::max(gap, job.figures.mold_distance[i]);
    if (sheet.contact[i] == Contact::platform) gap = std::max(gap, std::abs(sheet.formed[i].z()));
  }
  const FormingSummary& s = sheet.summary;
  const auto wrinkled = std::count_if(sheet.element_wrinkled.begin(), sheet.element_wrinkled.end(),
                                      [](auto v) { return v != 0; });
  Json out = {{"vertices", sheet.formed.size()},
              {"triangles", sheet.triangles.size()},
              {"vertices_by_contact",
               {{"free", counts[0]}, {"mold", counts[1]}, {"platform", counts[2]}, {"clamp", counts[3]}}},
              {"penetration_mm", deviation_of(sheet.fit.penetration)},
              {"gap_mm", deviation_of(sheet.fit.gap)},
              {"vertex_gap_mm", rounded(gap, 4)},
              {"drape_steps", s.drape_steps},
              {"vacuum_steps", s.vacuum_steps},
              {"iterations", s.iterations},
              {"converged", s.converged},
              {"residual", significant(s.residual)},
              {"kinetic_mj", significant(s.kinetic_mj)},
              {"pressure_kpa", rounded(s.pressure_kpa, 3)},
              {"shear_modulus_kpa", rounded(s.shear_modulus_kpa, 3)},
              {"mass_error", significant(s.mass_error)},
              {"force_error", significant(s.force_error)},
              {"wrinkled_triangles", wrinkled}};
  if (const auto& e = s.extrapolation)
    out["extrapolation"] = {{"grids_mm", {e->coarse_mm, e->fine_mm}},
                            {"mean_mm", rounded(e->mean, 4)},
                            {"p95_mm", rounded(e->p95, 4)},
                            {"max_mm", rounded(e->max, 4)}};
  return out;
}

// When the sheet meets the mold, over the window of the clamp frame.
Json heat_of(const HeatSummary& heat, Material material) {
  const MaterialProfile plastic = material_profile(material);
  Json out = {{"source", name(heat.source)},
              {"window_c", {plastic.coldest_celsius, plastic.hottest_celsius}},
              {"least_c", rounded(heat.least, 2)},
              {"mean_c", rounded(heat.mean, 2)},
              {"most_c", rounded(heat.most, 2)}};
  if (heat.seconds) out["seconds"] = rounded(*heat.seconds, 3);
  if (heat.through_thickness) out["through_thickness_c"] = rounded(*heat.through_thickness, 2);
  return out;
}

// Means over the plastic itself: an element is weighted by its area on the flat sheet.
Json thickness_of(const Finished& job) {
  const FormedSheet& sheet = job.sheet;
  double area = 0, sum = 0, chart_area = 0, chart_sum = 0;
  const auto rest_area = [&](std::size_t t) {
    const auto& c = sheet.triangles[t];
    const Eigen::Vector2d a = sheet.rest[c[1]] - sheet.rest[c[0]];
    const Eigen::Vector2d b = sheet.rest[c[2]] - sheet.rest[c[0]];
    return std::abs(cross(a, b)) / 2;
  };
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    area += rest_area(t), sum += rest_area(t) * sheet.element_thickness[t];
  }
  for (const int i : job.flattening.triangles) {
    const auto t = static_cast<std::size_t>(i);
    chart_area += rest_area(t), chart_sum += rest_area(t) * sheet.element_thickness[t];
  }
  const double initial = job.settings.sheet.thickness_mm;
  return {{"initial_mm", rounded(initial)},
          {"least_mm", rounded(job.figures.least_thickness)},
          {"mean_mm", rounded(sum / area)},
          {"least_ratio", rounded(job.figures.least_thickness / initial)},
          {"mean_ratio", rounded(sum / area / initial)},
          {"chart_least_ratio", rounded(job.figures.chart_least_thickness / initial)},
          {"chart_mean_ratio", rounded(chart_sum / chart_area / initial)}};
}

Json flattening_of(const Flattening& f) {
  Json out = {{"triangles", f.triangles.size()},
              {"iterations", f.iterations},
              {"energy", significant(f.energy)},
              {"symmetric_dirichlet", significant(f.symmetric_dirichlet)},
              {"flipped", f.flipped},
              {"crossings", f.crossings},
              {"top_rest_mm", array(f.top_rest, 3)}};
  if (!f.favoured.empty())
    out.update({{"favoured_triangles", std::count(f.favoured.begin(), f.favoured.end(), 1)},
                {"energy_favoured", significant(f.energy_favoured)},
                {"energy_rest", significant(f.energy_rest)}});
  return out;
}

Json pattern_of(const Finished& job) {
  Json out = {{"format", job.pattern.format()},
              {"size_mm", array(job.pattern.size_mm(), 3)},
              {"size_from", job.pattern.size_from()},
              {"size_pixels", {job.pattern.size_pixels().x(), job.pattern.size_pixels().y()}},
              {"grayscale", job.pattern.grayscale()},
              {"ink_area_mm2", rounded(job.pattern.ink_mm2(), 2)},
              {"ink_printed", rounded(job.print.main().ink_printed, 5)},
              {"ink_on_head", rounded(job.print.main().ink_on_head, 5)}};
  if (const LengthErrors& lengths = job.lengths; !lengths.pieces.empty())
    out["lengths"] = {{"mean_error", rounded(lengths.mean, 5)},
                      {"p95_error", rounded(lengths.p95, 5)},
                      {"worst_error", rounded(lengths.pieces.front().error, 5)},
                      {"worst_place_mm", array(lengths.pieces.front().place, 1)},
                      {"worst_angle_deg", rounded(lengths.worst_angle_deg, 2)}};
  if (!job.placed) return out;
  const auto& elements = job.placed->elements;
  const auto coils =
      std::count_if(elements.begin(), elements.end(), [](const Element& e) { return !!e.loop; });
  const auto loose =
      std::count_if(elements.begin(), elements.end(), [](const Element& e) { return e.id.empty(); });
  out["found"] = {{"coils", coils},
                  {"figures", static_cast<std::ptrdiff_t>(elements.size()) - coils - loose},
                  {"loose_ink_mm2", rounded(job.placed->loose_ink_mm2, 2)}};
  return out;
}

// Where the formed sheet takes the colours of the scan.
Json colours_of(const SheetColours& colours) {
  const ColouredArea& area = colours.area();
  const HiddenSurface& hidden = colours.hidden();
  Json largest = Json::array();
  for (const HiddenSurface::Area& each : hidden.largest)
    largest.push_back({{"place_mm", array(each.place, 1)}, {"mm2", rounded(each.mm2, 0)}});
  return {{"full_mm2", rounded(area.full_mm2, 1)},
          {"faded_mm2", rounded(area.faded_mm2, 1)},
          {"faded_share", rounded(area.faded_share(), 4)},
          {"distance_p99_mm", rounded(area.p99_mm, 3)},
          {"hidden_mm2", rounded(hidden.hidden_mm2, 0)},
          {"hidden_share", rounded(hidden.share(), 4)},
          {"hidden", std::move(largest)}};
}

// How far the colours are off on the formed part, and how different they look.
Json errors_of(const ColourErrors& errors) {
  const auto placed = [](const PlacedStatistics& s) {
    return Json{{"mean", rounded(s.values.mean, 3)},
                {"p95", rounded(s.values.p95, 3)},
                {"p99", rounded(s.values.p99, 3)},
                {"max", rounded(s.values.max, 3)},
                {"place_mm", array(s.place, 1)}};
  };
  const auto part = [&](const ColourErrors::Figures& figures) {
    return Json{{"position_mm", placed(figures.position)},
                {"along_mm", placed(figures.along)},
                {"ciede2000", placed(figures.colour)}};
  };
  Json off = Json::array();
  for (const ColourErrors::OffRegister& each : errors.off_register) {
    Json one = {{"shift_mm", each.shift_mm}};
    one.update(part(each.touching));
    off.push_back(std::move(one));
  }
  return {
      {"whole", part(errors.whole)}, {"touching", part(errors.touching)}, {"off_register", std::move(off)}};
}

// Where full ink is too little for the colours.
Json ink_of(const std::optional<InkShortage>& shortage) {
  if (!shortage) return nullptr;
  const bool any = shortage->lack > 0;
  return {{"short_mm2", rounded(shortage->short_mm2, 1)},
          {"short_share", rounded(shortage->share(), 4)},
          {"largest_lack", rounded(shortage->lack, 3)},
          {"of", any ? Json(ink_names[shortage->ink]) : Json()},
          {"place_mm", any ? array(shortage->place, 1) : Json()}};
}

Json print_of(const Finished& job) {
  return {{"size_pixels", {job.print.grid.width, job.print.grid.height}},
          {"dpi", job.settings.print.dpi},
          {"inked_face", name(job.print.main().face)},
          {"mirrored", job.print.main().mirrored()},
          {"ruler_mm", job.print.ruler_mm ? Json(*job.print.ruler_mm) : Json(nullptr)}};
}

Json statistics_of(const Statistics& s) {
  return {
      {"mean", rounded(s.mean)}, {"p95", rounded(s.p95)}, {"p99", rounded(s.p99)}, {"max", rounded(s.max)}};
}
Json distortion_json(const Distortion& d) {
  return {{"shape", statistics_of(d.shape)}, {"area", statistics_of(d.area)}};
}

Json way_json(const WayFigures& way) {
  Json out = distortion_json(way.chart);
  if (way.favoured) out["favoured"] = distortion_json(*way.favoured);
  if (way.rest) out["rest"] = distortion_json(*way.rest);
  return out;
}

// Shares of the inked area, the last bin with all that lies above.
Json histograms_of(const Finished& job) {
  std::vector<Weighted> thickness;
  for (std::size_t i = 0; i < job.flattening.triangles.size(); ++i) {
    const auto t = static_cast<std::size_t>(job.flattening.triangles[i]);
    const auto at = [&](std::size_t k) { return job.surface.inked()[job.sheet.triangles[t][k]]; };
    thickness.push_back({job.sheet.element_thickness[t] / job.settings.sheet.thickness_mm,
                         (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2});
  }
  const auto list = [](const std::vector<double>& shares) {
    Json out = Json::array();
    for (const double share : shares) out.push_back(rounded(share));
    return out;
  };
  const WayFigures &without = job.figures.without, &with = job.figures.with;
  const auto both = [&](std::vector<Weighted> DistortionValues::*values, const Statistics& of_without) {
    const Bins bins = even_bins(1, of_without.p99);
    return Json{{"low", bins.low},
                {"step", rounded(bins.step)},
                {"without", list(shares(without.triangles.*values, bins))},
                {"with", list(shares(with.triangles.*values, bins))}};
  };
  const Bins bins = even_bins(0, statistics(thickness).p99);
  return {{"shape", both(&DistortionValues::shape, without.chart.shape)},
          {"area", both(&DistortionValues::area, without.chart.area)},
          {"thickness_ratio",
           {{"low", bins.low}, {"step", rounded(bins.step)}, {"shares", list(shares(thickness, bins))}}}};
}

Json vents_of(const FormedSheet& sheet) {
  Json vents = Json::array();
  for (const Vent& vent : sheet.vents)
    vents.push_back({{"place_mm", array(vent.place, 1)}, {"diameter_mm", rounded(vent.diameter_mm, 1)}});
  return vents;
}

}  // namespace

Json report(const Finished& job) {
  Json out;
  out["settings"] = to_json(job.settings);
  out["scan"] = scan_json(job.mold.findings);
  out["mold"] = mold_json(job.mold);
  out["heat"] = heat_of(job.heat, job.settings.sheet.material);
  out["forming"] = forming_of(job);
  out["thickness"] = thickness_of(job);
  out["flattening"] = flattening_of(job.flattening);
  out["pattern"] = pattern_of(job);
  if (const Layer* const coloured = job.print.coloured()) {
    const PrintedColours& colours = *coloured->source->colours();
    out["pattern"]["colours"] = colours_of(colours.on_sheet);
    out["pattern"]["colours"]["ink"] = ink_of(colours.shortage);
    if (job.figures.errors) out["pattern"]["colours"]["errors"] = errors_of(*job.figures.errors);
  }
  out["print"] = print_of(job);
  out["figures"] = {{"without", way_json(job.figures.without)}, {"with", way_json(job.figures.with)}};
  if (const auto& measured_lines = job.figures.measured) {
    const Measured& measured = *measured_lines;
    for (const Way way : both_ways) {
      Json& figures = out["figures"][way == Way::with ? "with" : "without"];
      figures["coils"] = summary_json(measured.coils, way);
      if (measured.elements) figures["elements"] = distortion_json((*measured.elements)[way]);
    }
    out["coils"] = coils_json(measured.coils);
    out["pairs"] = pairs_json(measured.coils);
    out["couplings"] = couplings_json(measured.coils);
    out["circuits"] = circuits_json(job);
    out["ink"] = traces_json(measured.traces);
  }
  if (in_segments(job)) out["segments"] = segments_json(job.placement, job.print);
  out["histograms"] = histograms_of(job);
  out["maps"] = heat_maps_json(heat_maps(job));
  Json warnings = Json::array();
  const auto add = [&](Stage stage, const std::vector<Warning>& of_stage) {
    for (const auto& w : of_stage) warnings.push_back(warning_json(stage, w));
  };
  add(Stage::scan, job.mold.warnings);
  add(Stage::forming, job.sheet.warnings);
  add(Stage::flattening, job.flattening.warnings);
  add(Stage::printing, job.print.warnings);
  if (job.figures.measured) add(Stage::inspection, job.figures.measured->warnings);
  out["warnings"] = std::move(warnings);
  out["vents"] = vents_of(job.sheet);
  Json files = Json::array();
  for (const auto& kind : artifact_kinds)
    if (makes(job, kind)) files.push_back({{"name", kind.name}, {"title", kind.title}});
  out["artifacts"] = std::move(files);
  return out;
}

}  // namespace vacuform
