#include "worker/studies/ink_chart.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/strict_json.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int places_a_side = 9;  // of a patch
constexpr std::size_t most_patches = 1000;

// Formed over flat area of a triangle of the inked face.
double ratio_of(const InkedSurface& surface, int triangle) {
  const Triangle& t = surface.triangles()[triangle];
  const auto at = [&](const auto& points, std::size_t k) { return points[t[k]]; };
  const Vector3d p = at(surface.inked(), 1) - at(surface.inked(), 0),
                 q = at(surface.inked(), 2) - at(surface.inked(), 0);
  const Vector2d a = at(surface.rest(), 1) - at(surface.rest(), 0),
                 b = at(surface.rest(), 2) - at(surface.rest(), 0);
  return p.cross(q).norm() / std::abs(cross(a, b));
}

double rounded_to(double value, double scale) { return std::round(value * scale) / scale + 0.0; }

}  // namespace

bool find_stretch(const FormedSheet& sheet, const InkedSurface& surface, double across_mm,
                  std::vector<InkPatch>& patches) {
  std::vector<Vector2d> plan;
  for (const Vector3d& p : sheet.formed) plan.push_back(p.head<2>());
  const PlaneLocator locator(sheet.triangles, plan);
  for (InkPatch& patch : patches) {
    double thinned = 0;
    patch.least_ratio = INFINITY, patch.most_ratio = 0, patch.gap_mm = 0;
    for (int i = 0; i < places_a_side; ++i)
      for (int j = 0; j < places_a_side; ++j) {
        const Vector2d at = patch.place.head<2>() + across_mm * Vector2d((i + 0.5) / places_a_side - 0.5,
                                                                         (j + 0.5) / places_a_side - 0.5);
        const auto found = locator.find(at);
        if (!found) return false;
        const double ratio = ratio_of(surface, found->triangle);
        if (!(ratio > 0) || !std::isfinite(ratio)) return false;
        thinned += 1 / ratio;
        patch.least_ratio = std::min(patch.least_ratio, ratio);
        patch.most_ratio = std::max(patch.most_ratio, ratio);
        patch.gap_mm =
            std::max(patch.gap_mm, interpolate(sheet.triangles, *found, sheet.formed).z() - patch.place.z());
        if (i == places_a_side / 2 && j == i) patch.rest = interpolate(sheet.triangles, *found, sheet.rest);
      }
    patch.area_ratio = places_a_side * places_a_side / thinned;
  }
  return true;
}

nlohmann::ordered_json patches_json(const std::vector<InkPatch>& patches) {
  auto out = nlohmann::ordered_json::array();
  for (const InkPatch& p : patches)
    out.push_back(
        {{"id", p.id},
         {"step", p.step},
         {"ink", p.ink < 0 ? "none" : ink_names[static_cast<std::size_t>(p.ink)]},
         {"coverage", rounded_to(p.coverage, 1e5)},
         {"area_ratio", rounded_to(p.area_ratio, 1e4)},
         {"least_area_ratio", rounded_to(p.least_ratio, 1e4)},
         {"most_area_ratio", rounded_to(p.most_ratio, 1e4)},
         {"gap_mm", rounded_to(p.gap_mm, 1e3)},
         {"place_mm",
          {rounded_to(p.place.x(), 1e2), rounded_to(p.place.y(), 1e2), rounded_to(p.place.z(), 1e2)}},
         {"sheet_mm", {rounded_to(p.rest.x(), 1e2), rounded_to(p.rest.y(), 1e2)}}});
  return out;
}

Result<std::vector<InkPatch>> read_patches(std::span<const std::uint8_t> json, const std::string& file_name) {
  const auto refuse = [&](std::string what) {
    return fail(Code::corrupt_file, std::move(what), file_name,
                "give the chart.json that vacuform chart wrote");
  };
  const auto parsed = strict_json<nlohmann::json>({reinterpret_cast<const char*>(json.data()), json.size()});
  if (!parsed) return refuse(std::string("not JSON: ") + parsed.error().what);
  if (!parsed->is_object() || !parsed->contains("patches") || !(*parsed)["patches"].is_array())
    return refuse("it has no list of patches");
  std::vector<InkPatch> patches;
  for (const nlohmann::json& row : (*parsed)["patches"]) {
    InkPatch patch;
    const auto number = [&](const char* key, double low, double high, double& value) {
      if (!row.contains(key) || !row[key].is_number()) return false;
      value = row[key].get<double>();
      return value >= low && value <= high;
    };
    double step = 0;
    if (!row.is_object() || !row.contains("id") || !row["id"].is_string() || !row.contains("ink") ||
        !row["ink"].is_string() || !number("coverage", 0, 1, patch.coverage) ||
        !number("area_ratio", 0.05, 1000, patch.area_ratio) || !number("step", 1, 100, step))
      return refuse(std::string("patch ") + std::to_string(patches.size() + 1) +
                    " lacks one of id, step, ink, coverage and area_ratio, or it is out of range");
    patch.id = row["id"].get<std::string>();
    patch.step = static_cast<int>(step);
    const auto& ink = row["ink"].get_ref<const std::string&>();
    const auto name = std::find(ink_names.begin(), ink_names.end(), ink);
    if (name == ink_names.end() && ink != "none")
      return refuse(std::string("patch ") + std::to_string(patches.size() + 1) + " has an unknown ink");
    patch.ink = ink == "none" ? -1 : static_cast<int>(name - ink_names.begin());
    if (patches.size() == most_patches) return refuse("more than 1000 patches");
    patches.push_back(std::move(patch));
  }
  return patches;
}

std::string table_to_fill(const std::vector<InkPatch>& patches) {
  std::string out =
      "# CIE L*a*b* (D50, 2 degrees) of the formed patches. Leave rows empty that are not "
      "measured.\npatch,L,a,b\n";
  for (const InkPatch& patch : patches) out += patch.id + ",,,\n";
  return out;
}

}  // namespace vacuform
