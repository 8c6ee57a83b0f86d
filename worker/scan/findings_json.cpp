#include "worker/scan/findings_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit + 0.0; }
Json array(const Eigen::Vector3d& v, double per_unit) {
  return {rounded(v.x(), per_unit), rounded(v.y(), per_unit), rounded(v.z(), per_unit)};
}

}  // namespace

Json scan_json(const ScanFindings& f) {
  return {{"format", f.format},
          {"triangles_read", f.triangles_read},
          {"unit", f.size_given ? Json(nullptr) : Json(name(f.unit))},
          {"unit_guessed", f.unit_guessed},
          {"size_given", f.size_given},
          {"up", name(f.up)},
          {"up_guessed", f.up_guessed},
          {"front", name(f.front)},
          {"front_from_format", f.front_from_format},
          {"front_assumed", f.front_assumed},
          {"space", f.space == PatientSpace::unknown ? Json(nullptr) : Json(name(f.space))},
          {"left_from_file", f.left_from_file ? Json(name(*f.left_from_file)) : Json(nullptr)},
          {"mirrored", f.mirrored},
          {"left_side", name(f.left_side)},
          {"outliers_dropped", f.outliers_dropped},
          {"components", f.components},
          {"components_dropped", f.components_dropped},
          {"turned_inside_out", f.turned_inside_out},
          {"holes_closed", f.holes_closed},
          {"holes_capped", f.holes_capped},
          {"rebuilt", f.rebuilt},
          {"size_mm", array(f.size_mm, 100)},
          {"trim_mm", rounded(f.trim_mm, 100)},
          {"trim_chosen", f.trim_chosen},
          {"crumbs_dropped", f.crumbs_dropped}};
}

Json mold_json(const Mold& mold) {
  Json undercuts = Json::array();
  for (std::size_t i = 0; i < std::min<std::size_t>(mold.undercuts.size(), 20); ++i) {
    const auto& u = mold.undercuts[i];
    undercuts.push_back({{"place_mm", array(u.place, 10)},
                         {"depth_mm", rounded(u.depth_mm, 100)},
                         {"area_mm2", rounded(u.area_mm2, 10)}});
  }
  return {{"triangles", mold.mesh.triangles.size()},
          {"size_mm", array(bounds(mold.mesh).size(), 100)},
          {"top_mm", array(mold.top, 100)},
          {"undercut_count", mold.undercuts.size()},
          {"undercuts", undercuts}};
}

}  // namespace vacuform
