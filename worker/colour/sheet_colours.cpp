#include "worker/colour/sheet_colours.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

// The distance between a sheet and a scan that it touches: from the mold's surface and the chords of the sheet's
// triangles.
constexpr double contact_mm = 0.5;
// A surface that was grown is off by up to this share of the clearance.
constexpr double growth_share = 0.25;

struct AtDistance {
  double distance_mm, area_mm2;
};

double percentile_99(std::vector<AtDistance> all) {
  std::sort(all.begin(), all.end(),
            [](const AtDistance& a, const AtDistance& b) { return a.distance_mm < b.distance_mm; });
  double total = 0, sum = 0;
  for (const AtDistance& each : all) total += each.area_mm2;
  for (const AtDistance& each : all)
    if ((sum += each.area_mm2) >= 0.99 * total) return each.distance_mm;
  return 0;
}

}  // namespace

double ColourReach::share(double distance_mm) const {
  if (distance_mm <= touch_mm) return 1;
  return fade_mm > 0 ? std::max(0.0, 1 - (distance_mm - touch_mm) / fade_mm) : 0;
}

ColourReach colour_reach(double clearance_mm, double fade_mm) {
  return {.touch_mm = contact_mm + (1 + growth_share) * clearance_mm, .fade_mm = fade_mm};
}

SheetColours::SheetColours(ColouredSurface surface, const FormedSheet& sheet, const ColourReach& reach)
    : surface_(std::move(surface)), sheet_(sheet), reach_(reach), nearest_triangle_(sheet.formed.size(), -1) {
  const auto at = [&](int v) -> const Eigen::Vector3d& { return sheet.formed[v]; };
  // If a triangle has a place in reach, its corners are at most its longest side further away.
  double longest = 0;
  for (const Triangle& t : sheet.triangles)
    for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, (at(t[k]) - at(t[(k + 1) % 3])).norm());
  const double far = std::numeric_limits<double>::infinity();
  std::vector<double> distance(sheet.formed.size(), far);
  in_parallel(0, static_cast<int>(sheet.formed.size()), [&](int first, int last) {
    for (int v = first; v < last; ++v)
      if (const auto nearest = surface_.nearest(at(v), reach.end_mm() + longest)) {
        distance[v] = nearest->distance_mm;
        nearest_triangle_[v] = nearest->triangle;
      }
  });
  std::vector<AtDistance> coloured;
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const Triangle& corners = sheet.triangles[t];
    double nearest = far, farthest = 0, side = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = distance[corners[k]];
      nearest = std::min(nearest, d);
      farthest = std::max(farthest, d);
      side = std::max(side, (at(corners[k]) - at(corners[(k + 1) % 3])).norm());
    }
    if (nearest > reach.end_mm() + side) continue;
    triangles_.push_back(static_cast<int>(t));
    const double area = 0.5 * (at(corners[1]) - at(corners[0])).cross(at(corners[2]) - at(corners[0])).norm();
    if (farthest > reach.end_mm()) continue;
    (farthest <= reach.touch_mm ? area_.full_mm2 : area_.faded_mm2) += area;
    coloured.push_back({farthest, area});
  }
  area_.p99_mm = percentile_99(std::move(coloured));
  hidden_ = hidden_surface(surface_, sheet, reach.touch_mm);
}

}  // namespace vacuform
