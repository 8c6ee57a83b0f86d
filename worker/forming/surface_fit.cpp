#include "worker/forming/surface_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "worker/scan/mold_distance.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

constexpr double side_mm = 1;    // of the small triangles that samples stand for: they are half of it apart
constexpr double beside_mm = 1;  // the mold that is further below the sheet has nothing to do with it
constexpr double platform_mm = 0.05;  // the mold's foot
constexpr double skin_mm = 0.02;  // below the mold's surface: a wall that the sheet lies on is not in its way
constexpr int most_parts = 64;    // of a triangle's side

// Calls with the middles of the small triangles into which a triangle is cut, and the area of each.
template <class Call>
void for_each_sample(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                     const Call& call) {
  const double longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  const int n = std::clamp(static_cast<int>(std::ceil(longest / side_mm)), 1, most_parts);
  const double area = (b - a).cross(c - a).norm() / 2 / (n * n);
  const auto sample = [&](double u, double v) { call(a + u / n * (b - a) + v / n * (c - a), area); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      sample(i + 1.0 / 3, j + 1.0 / 3);
      if (i + j < n - 1) sample(i + 2.0 / 3, j + 2.0 / 3);
    }
}

// What is kept of samples: their depths, and the places of those beyond a limit.
struct Depths {
  struct Place {
    Eigen::Vector3d place;
    double depth;
  };

  void add(const Eigen::Vector3d& place, double area, double depth, double limit_mm) {
    whole += area;
    if (depth > 0 && area > 0) depth_and_area.emplace_back(depth, area);
    if (depth >= deepest.depth) deepest = {place, depth};
    if (depth > limit_mm) beyond.push_back({place, depth});
  }
  void append(const Depths& later) {
    whole += later.whole;
    depth_and_area.insert(depth_and_area.end(), later.depth_and_area.begin(), later.depth_and_area.end());
    if (later.deepest.depth >= deepest.depth) deepest = later.deepest;
    beyond.insert(beyond.end(), later.beyond.begin(), later.beyond.end());
  }

  double whole = 0;                                       // area
  std::vector<std::pair<double, double>> depth_and_area;  // where the depth is not zero
  Place deepest{Eigen::Vector3d::Zero(), 0};
  std::vector<Place> beyond;
};

// Of the sheet against the mold.
struct SheetDepths {
  void append(const SheetDepths& later) {
    off.append(later.off);
    sunk.append(later.sunk);
  }
  Depths off, sunk;  // above it, in it
};

// Sums measure(k, sums) over [0, count), on all threads; the result does not depend on their number.
template <class Sums, class Measure>
Sums measure_all(std::size_t count, const Measure& measure) {
  constexpr std::size_t blocks = 64;
  std::vector<Sums> parts(blocks);
  in_parallel(0, blocks, [&](int first, int last) {
    for (int block = first; block < last; ++block) {
      const auto at = static_cast<std::size_t>(block);
      for (std::size_t k = count * at / blocks; k < count * (at + 1) / blocks; ++k) measure(k, parts[at]);
    }
  });
  Sums all;
  for (const Sums& part : parts) all.append(part);
  return all;
}

TriangleMesh mesh_of(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& places) {
  return {places, triangles};
}

Deviation deviation_of(Depths depths) {
  Deviation out;
  out.max = depths.deepest.depth;
  out.place = depths.deepest.place;
  // From the deepest down, until one hundredth of the area is deeper.
  auto& heap = depths.depth_and_area;
  std::make_heap(heap.begin(), heap.end());
  double deeper = 0;
  while (!heap.empty() && deeper <= 0.01 * depths.whole) {
    std::pop_heap(heap.begin(), heap.end());
    out.p99 = heap.back().first;
    deeper += heap.back().second;
    heap.pop_back();
  }
  if (deeper <= 0.01 * depths.whole) out.p99 = 0;
  return out;
}

// The parts that these samples make up, deepest first.
std::vector<Misfit> parts_of(const std::vector<Depths::Place>& samples) {
  constexpr double cell_mm = 3;
  using Cell = std::array<int, 3>;
  std::map<Cell, std::vector<const Depths::Place*>> cells;
  for (const Depths::Place& s : samples) {
    const Eigen::Vector3i c = (s.place / cell_mm).array().floor().cast<int>();
    cells[{c.x(), c.y(), c.z()}].push_back(&s);
  }
  std::vector<Misfit> parts;
  while (!cells.empty()) {
    std::vector<Cell> open{cells.begin()->first};
    std::vector<const Depths::Place*> all;
    while (!open.empty()) {
      const Cell c = open.back();
      open.pop_back();
      const auto found = cells.find(c);
      if (found == cells.end()) continue;
      all.insert(all.end(), found->second.begin(), found->second.end());
      cells.erase(found);
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z) open.push_back({c[0] + x, c[1] + y, c[2] + z});
    }
    const Depths::Place& deepest = **std::max_element(
        all.begin(), all.end(),
        [](const Depths::Place* a, const Depths::Place* b) { return a->depth < b->depth; });
    double reach = deepest.depth;
    for (const Depths::Place* s : all) reach = std::max(reach, (s->place - deepest.place).norm());
    parts.push_back({deepest.place, deepest.depth, 2 * reach});
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Misfit& a, const Misfit& b) { return a.distance_mm > b.distance_mm; });
  return parts;
}

std::array<Eigen::Vector3d, 3> corners_of(const TriangleMesh& mesh, std::size_t triangle) {
  const Triangle& t = mesh.triangles[triangle];
  return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

}  // namespace

SurfaceFit surface_fit(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& formed,
                       const std::vector<Contact>& contact, const TriangleMesh& mold,
                       const FitLimits& limits) {
  const TriangleMesh sheet = mesh_of(triangles, formed);
  const RayCaster to_sheet(sheet), to_mold(mold);
  const MoldDistance from_sheet(sheet, to_sheet), from_mold(mold, to_mold);
  double height = 1;
  for (const auto& p : formed) height = std::max(height, p.z() + 1);
  for (const auto& p : mold.vertices) height = std::max(height, p.z() + 1);

  // How far the mold stands out of the sheet.
  const auto add_mold = [&](const Eigen::Vector3d& place, const Eigen::Vector3d& normal, double area,
                            Depths& depths) {
    if (place.z() <= platform_mm) return;
    if (!lies_below(sheet, to_sheet, place - skin_mm * normal, height))
      depths.add(place, area, from_sheet(place), limits.pierced_mm);
    else if (from_sheet.within(place, beside_mm))
      depths.add(place, area, 0, limits.pierced_mm);
  };
  Depths of_mold = measure_all<Depths>(mold.triangles.size(), [&](std::size_t k, Depths& depths) {
    const auto [a, b, c] = corners_of(mold, k);
    if (std::max({a.z(), b.z(), c.z()}) <= platform_mm) return;
    const Eigen::Vector3d normal = (b - a).cross(c - a).stableNormalized();
    for_each_sample(
        a, b, c, [&](const Eigen::Vector3d& place, double area) { add_mold(place, normal, area, depths); });
  });
  std::vector<Eigen::Vector3d> normals(mold.vertices.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < mold.triangles.size(); ++k) {
    const auto [a, b, c] = corners_of(mold, k);
    const Eigen::Vector3d normal = (b - a).cross(c - a).stableNormalized();
    for (const int v : mold.triangles[k]) normals[v] += normal;
  }
  of_mold.append(measure_all<Depths>(mold.vertices.size(), [&](std::size_t v, Depths& depths) {
    add_mold(mold.vertices[v], normals[v].stableNormalized(), 0, depths);
  }));

  // How far the sheet is off the mold where all three corners of a triangle touch it, and how deep it lies in the mold
  // where any of them does. Of the second only the deepest place and those beyond the limit count.
  auto [off, sunk] = measure_all<SheetDepths>(triangles.size(), [&](std::size_t k, SheetDepths& depths) {
    const Triangle& t = triangles[k];
    const auto touching =
        std::count_if(t.begin(), t.end(), [&](int v) { return contact[v] == Contact::mold; });
    if (touching == 0) return;
    const auto [a, b, c] = corners_of(sheet, k);
    for_each_sample(a, b, c, [&](const Eigen::Vector3d& place, double area) {
      const bool inside = lies_below(mold, to_mold, place, height);
      if (touching == 3) depths.off.add(place, area, inside ? 0 : from_mold(place), limits.bridged_mm);
      const double known = std::min(depths.sunk.deepest.depth, limits.pierced_mm);
      if (inside && place.z() > platform_mm && !from_mold.within(place, known))
        depths.sunk.add(place, 0, from_mold(place), limits.pierced_mm);
    });
  });
  SurfaceFit fit;
  sunk.beyond.insert(sunk.beyond.end(), of_mold.beyond.begin(), of_mold.beyond.end());
  fit.pierced = parts_of(sunk.beyond);
  fit.bridged = parts_of(off.beyond);
  fit.penetration = deviation_of(std::move(of_mold));
  if (sunk.deepest.depth > fit.penetration.max)
    fit.penetration.max = sunk.deepest.depth, fit.penetration.place = sunk.deepest.place;
  fit.gap = deviation_of(std::move(off));
  return fit;
}

}  // namespace vacuform
