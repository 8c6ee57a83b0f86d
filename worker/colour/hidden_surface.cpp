#include "worker/colour/hidden_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double apart_mm = 2, cell_mm = 4, least_mm2 = 25;
constexpr std::size_t most_areas = 5;
constexpr int most_steps = 64;

struct Spot {
  Vector3d place;
  double mm2;
};
using Cell = std::array<int, 3>;

// Divides a triangle into equal parts and takes the middle of each. Neighbours are at most `apart_mm` apart, unless a
// side is longer than 128 mm.
template <class Each>
void each_spot(const std::array<Vector3d, 3>& corners, Each&& each) {
  const Vector3d a = corners[1] - corners[0], b = corners[2] - corners[0];
  const double longest = std::max({a.norm(), b.norm(), (a - b).norm()});
  const double area = a.cross(b).norm() / 2;
  if (!(area > 0)) return;
  const int n = std::clamp(static_cast<int>(std::ceil(longest / apart_mm)), 1, most_steps);
  const double step = 1.0 / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      each(Spot{corners[0] + (i + 1.0 / 3) * step * a + (j + 1.0 / 3) * step * b, area * step * step});
      if (i + j + 1 < n)
        each(Spot{corners[0] + (i + 2.0 / 3) * step * a + (j + 2.0 / 3) * step * b, area * step * step});
    }
}

// The spots of one triangle, and what of them is hidden.
struct Looked {
  double whole_mm2 = 0, hidden_mm2 = 0;
  std::vector<Spot> hidden;
};
Looked look(const TriangleMesh& mesh, int triangle, const MoldDistance& sheet, double touch_mm) {
  std::array<Vector3d, 3> corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = mesh.vertices[mesh.triangles[static_cast<std::size_t>(triangle)][k]];
  Looked out;
  each_spot(corners, [&](const Spot& spot) {
    if (!(spot.place.z() > 0)) return;
    out.whole_mm2 += spot.mm2;
    if (sheet.within(spot.place, touch_mm)) return;
    out.hidden_mm2 += spot.mm2;
    out.hidden.push_back(spot);
  });
  return out;
}

Cell cell_of(const Vector3d& place) {
  return {static_cast<int>(std::floor(place.x() / cell_mm)),
          static_cast<int>(std::floor(place.y() / cell_mm)),
          static_cast<int>(std::floor(place.z() / cell_mm))};
}

// The whole area of the spots, and the spot nearest to their mean.
HiddenSurface::Area area_of(const std::vector<Spot>& spots) {
  HiddenSurface::Area area{Vector3d::Zero(), 0};
  for (const Spot& spot : spots) {
    area.place += spot.mm2 * spot.place;
    area.mm2 += spot.mm2;
  }
  const Vector3d mean = area.place / area.mm2;
  area.place = std::min_element(spots.begin(), spots.end(), [&](const Spot& a, const Spot& b) {
                 return (a.place - mean).squaredNorm() < (b.place - mean).squaredNorm();
               })->place;
  return area;
}

// Spots whose cells touch form one area.
std::vector<HiddenSurface::Area> areas_of(const std::vector<Spot>& hidden) {
  std::map<Cell, std::vector<Spot>> cells;
  for (const Spot& spot : hidden) cells[cell_of(spot.place)].push_back(spot);
  std::vector<HiddenSurface::Area> areas;
  while (!cells.empty()) {
    std::vector<Cell> open{cells.begin()->first};
    std::vector<Spot> spots = std::move(cells.begin()->second);
    cells.erase(cells.begin());
    while (!open.empty()) {
      const Cell at = open.back();
      open.pop_back();
      for (int i = 0; i < 27; ++i) {
        const auto found = cells.find({at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1});
        if (found == cells.end()) continue;
        open.push_back(found->first);
        spots.insert(spots.end(), found->second.begin(), found->second.end());
        cells.erase(found);
      }
    }
    const HiddenSurface::Area area = area_of(spots);
    if (area.mm2 >= least_mm2) areas.push_back(area);
  }
  std::stable_sort(areas.begin(), areas.end(), [](const auto& a, const auto& b) { return a.mm2 > b.mm2; });
  areas.resize(std::min(areas.size(), most_areas));
  return areas;
}

}  // namespace

HiddenSurface hidden_surface(const ColouredSurface& surface, const FormedSheet& sheet, double touch_mm) {
  const TriangleMesh formed{sheet.formed, sheet.triangles};
  const MoldDistance to_sheet(formed);
  const TriangleMesh& mesh = surface.mesh();
  const int triangles = static_cast<int>(mesh.triangles.size());
  std::vector<Looked> looked(mesh.triangles.size());
  in_parallel(0, triangles, [&](int first, int last) {
    for (int t = first; t < last; ++t) looked[t] = look(mesh, t, to_sheet, touch_mm);
  });
  HiddenSurface out;
  std::vector<Spot> hidden;
  for (const Looked& each : looked) {
    out.whole_mm2 += each.whole_mm2;
    out.hidden_mm2 += each.hidden_mm2;
    hidden.insert(hidden.end(), each.hidden.begin(), each.hidden.end());
  }
  out.largest = areas_of(hidden);
  return out;
}

}  // namespace vacuform
