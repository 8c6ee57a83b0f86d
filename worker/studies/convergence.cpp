#include "worker/studies/convergence.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/stage/sub_progress.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

double rounded(double value, int places = 4) {
  const double scale = std::pow(10.0, places);
  return std::round(value * scale) / scale + 0.0;
}

// The slope of the steepest triangle around a vertex, in degrees from level.
double slope_at(const FormedSheet& sheet, int vertex) {
  double steepest = 0;
  for (const Triangle& t : sheet.triangles) {
    if (t[0] != vertex && t[1] != vertex && t[2] != vertex) continue;
    const Eigen::Vector3d &a = sheet.formed[t[0]], &b = sheet.formed[t[1]], &c = sheet.formed[t[2]];
    const Eigen::Vector3d n = (b - a).cross(c - a);
    steepest = std::max(steepest, std::atan2(n.head<2>().norm(), n.z()));
  }
  return steepest * 180 / std::numbers::pi;
}

template <class Vector>
Json array(const Vector& v) {
  Json out = Json::array();
  for (int k = 0; k < v.size(); ++k) out.push_back(rounded(v[k], 2));
  return out;
}

}  // namespace

Refinement compare(const FormedSheet& coarse, const FormedSheet& fine) {
  Refinement out;
  const SheetMap map(coarse);
  std::vector<double> head, sheet;
  double worst = -1;
  int worst_vertex = 0;
  for (std::size_t i = 0; i < fine.rest.size(); ++i) {
    const auto there = map(fine.rest[i]);
    if (!there) continue;
    const double distance = (*there - fine.formed[i]).norm();
    sheet.push_back(distance);
    if (fine.contact[i] != Contact::mold) continue;
    head.push_back(distance);
    if (distance > worst) worst = distance, worst_vertex = static_cast<int>(i);
  }
  out.worst_rest = fine.rest[worst_vertex];
  out.worst_formed = fine.formed[worst_vertex];
  out.worst_degrees = slope_at(fine, worst_vertex);
  out.head = statistics_of(std::move(head));
  out.sheet = statistics_of(std::move(sheet));
  return out;
}

DistanceStatistics statistics_of(std::vector<double> d) {
  DistanceStatistics out;
  if (d.empty()) return out;
  std::sort(d.begin(), d.end());
  const auto n = static_cast<double>(d.size());
  const auto percentile = [&](double share) { return d[static_cast<std::size_t>(std::ceil(share * n)) - 1]; };
  out.count = d.size();
  out.mean = std::accumulate(d.begin(), d.end(), 0.0) / n;
  out.rms = std::sqrt(std::inner_product(d.begin(), d.end(), d.begin(), 0.0) / n);
  out.p95 = percentile(0.95), out.p99 = percentile(0.99), out.max = d.back();
  return out;
}

Result<Convergence> converge(const Prepared& prepared, const Settings& settings,
                             const std::vector<double>& factors, const Context& context) {
  // A grid costs about the third power of its number of lines.
  double whole = 0, done = 0;
  for (const double factor : factors) whole += std::pow(factor, -3);
  Convergence out;
  FormedSheet coarse;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    Settings s = settings;
    s.sheet.resolution_mm = factors[k] * settings.sheet.resolution_mm;
    const double from = done / whole;
    done += std::pow(factors[k], -3);
    const SubProgress portion(context, {Stage::forming, from, done / whole});
    VACUFORM_TRY(fine,
                 form(prepared.mold, s.sheet, s.machine, s.forming, prepared.temperature, portion.context()));
    if (k > 0) {
      out.refinements.push_back(compare(coarse, fine));
      out.refinements.back().coarse_mm = factors[k - 1] * settings.sheet.resolution_mm;
      out.refinements.back().fine_mm = s.sheet.resolution_mm;
    }
    coarse = std::move(fine);
  }
  const std::size_t n = out.refinements.size();
  if (n >= 2 && out.refinements[n - 1].head.mean > 0 && out.refinements[n - 2].head.mean > 0)
    out.order = std::log2(out.refinements[n - 2].head.mean / out.refinements[n - 1].head.mean);
  return out;
}

Json json_of(const DistanceStatistics& s) {
  return {{"count", s.count},      {"mean", rounded(s.mean)}, {"rms", rounded(s.rms)},
          {"p95", rounded(s.p95)}, {"p99", rounded(s.p99)},   {"max", rounded(s.max)}};
}

Json json_of(const Convergence& convergence) {
  Json out;
  out["refinements"] = Json::array();
  for (const Refinement& r : convergence.refinements)
    out["refinements"].push_back({{"coarse_mm", r.coarse_mm},
                                  {"fine_mm", r.fine_mm},
                                  {"head_mm", json_of(r.head)},
                                  {"sheet_mm", json_of(r.sheet)},
                                  {"worst_on_head",
                                   {{"sheet_mm", array(r.worst_rest)},
                                    {"formed_mm", array(r.worst_formed)},
                                    {"slope_deg", rounded(r.worst_degrees, 1)}}}});
  out["order"] = convergence.order ? Json(rounded(*convergence.order, 2)) : Json(nullptr);
  return out;
}

}  // namespace vacuform
