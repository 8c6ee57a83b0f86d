#include "worker/forming/surface_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "worker/scan/mold_distance.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

constexpr double sample_mm = 0.75;
constexpr double beside_mm = 1;  // the mold that is further below the sheet has nothing to do with it
constexpr int most_parts = 64;   // of a triangle's side

constexpr double skin_mm = 0.02;  // below the mold's surface: a wall that the sheet lies on is not in its way

struct Sample {
  Eigen::Vector3d place, below;  // on the surface, and just under it
  double area;
  double depth = -1;  // -1: does not count
};

// The middles of the small triangles into which a triangle is cut.
void add_samples(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                 std::vector<Sample>& samples) {
  const double longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  const int n = std::clamp(static_cast<int>(std::ceil(longest / sample_mm)), 1, most_parts);
  const Eigen::Vector3d normal = (b - a).cross(c - a), skin = skin_mm * normal.stableNormalized();
  const double area = normal.norm() / 2 / (n * n);
  const auto add = [&](double u, double v) {
    const Eigen::Vector3d place = a + u / n * (b - a) + v / n * (c - a);
    samples.push_back({place, place - skin, area});
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      add(i + 1.0 / 3, j + 1.0 / 3);
      if (i + j < n - 1) add(i + 2.0 / 3, j + 2.0 / 3);
    }
}

TriangleMesh mesh_of(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& places) {
  return {places, triangles};
}

Deviation deviation_of(std::vector<Sample>& samples) {
  std::erase_if(samples, [](const Sample& s) { return s.depth < 0; });
  Deviation out;
  if (samples.empty()) return out;
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.depth < b.depth; });
  double whole = 0, sum = 0;
  for (const Sample& s : samples) whole += s.area;
  out.p99 = out.max = samples.back().depth;
  out.place = samples.back().place;
  for (const Sample& s : samples)
    if ((sum += s.area) >= 0.99 * whole) {
      out.p99 = s.depth;
      break;
    }
  return out;
}

// The parts that samples deeper than the limit make up, deepest first.
std::vector<Misfit> parts_beyond(const std::vector<Sample>& samples, double limit_mm) {
  constexpr double cell_mm = 3;
  using Cell = std::array<int, 3>;
  std::map<Cell, std::vector<const Sample*>> cells;
  for (const Sample& s : samples) {
    const Eigen::Vector3i c = (s.place / cell_mm).array().floor().cast<int>();
    if (s.depth > limit_mm) cells[{c.x(), c.y(), c.z()}].push_back(&s);
  }
  std::vector<Misfit> parts;
  while (!cells.empty()) {
    std::vector<Cell> open{cells.begin()->first};
    std::vector<const Sample*> all;
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
    const Sample& deepest = **std::max_element(
        all.begin(), all.end(), [](const Sample* a, const Sample* b) { return a->depth < b->depth; });
    double reach = deepest.depth;
    for (const Sample* s : all) reach = std::max(reach, (s->place - deepest.place).norm());
    parts.push_back({deepest.place, deepest.depth, 2 * reach});
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Misfit& a, const Misfit& b) { return a.distance_mm > b.distance_mm; });
  return parts;
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

  std::vector<Sample> of_mold, of_sheet;
  constexpr double platform_mm = 0.05;  // the mold's foot
  for (const Triangle& t : mold.triangles) {
    const auto &a = mold.vertices[t[0]], &b = mold.vertices[t[1]], &c = mold.vertices[t[2]];
    if (std::max({a.z(), b.z(), c.z()}) > platform_mm) add_samples(a, b, c, of_mold);
  }
  std::vector<Eigen::Vector3d> normal(mold.vertices.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : mold.triangles) {
    const Eigen::Vector3d a = mold.vertices[t[0]];
    const Eigen::Vector3d n = (mold.vertices[t[1]] - a).cross(mold.vertices[t[2]] - a).stableNormalized();
    for (const int v : t) normal[v] += n;
  }
  for (std::size_t v = 0; v < normal.size(); ++v)
    of_mold.push_back({mold.vertices[v], mold.vertices[v] - skin_mm * normal[v].stableNormalized(), 0});
  in_parallel(0, static_cast<int>(of_mold.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      Sample& s = of_mold[k];
      if (s.place.z() <= platform_mm) continue;
      const bool inside = lies_below(sheet, to_sheet, s.below, height);
      const double distance = from_sheet(s.place);
      if (!inside)
        s.depth = distance;
      else if (distance < beside_mm)
        s.depth = 0;
    }
  });
  // The sheet, where a corner touches the mold: how deep it lies in the mold, and how far off where all three touch.
  std::vector<Sample> sunk;
  std::vector<char> touches;
  for (const Triangle& t : triangles) {
    const auto corners =
        std::count_if(t.begin(), t.end(), [&](int v) { return contact[v] == Contact::mold; });
    if (corners > 0) add_samples(formed[t[0]], formed[t[1]], formed[t[2]], sunk);
    touches.resize(sunk.size(), corners == 3);
  }
  of_sheet = sunk;
  in_parallel(0, static_cast<int>(sunk.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const bool inside = lies_below(mold, to_mold, sunk[k].place, height);
      const double distance = from_mold(sunk[k].place);
      sunk[k].depth = inside && sunk[k].place.z() > platform_mm ? distance : 0;
      if (touches[k]) of_sheet[k].depth = inside ? 0 : distance;
    }
  });
  SurfaceFit fit;
  const Deviation deepest = deviation_of(sunk);
  sunk.insert(sunk.end(), of_mold.begin(), of_mold.end());
  fit.pierced = parts_beyond(sunk, limits.pierced_mm);
  fit.bridged = parts_beyond(of_sheet, limits.bridged_mm);
  fit.penetration = deviation_of(of_mold);
  if (deepest.max > fit.penetration.max)
    fit.penetration.max = deepest.max, fit.penetration.place = deepest.place;
  fit.gap = deviation_of(of_sheet);
  return fit;
}

}  // namespace vacuform
