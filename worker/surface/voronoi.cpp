#include "worker/surface/voronoi.hpp"

#include <limits>
#include <map>

#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

std::size_t nearest(const std::vector<Vector3d>& sites, const Vector3d& p) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < sites.size(); ++i)
    if ((sites[i] - p).squaredNorm() < (sites[best] - p).squaredNorm()) best = i;
  return best;
}

}  // namespace

Tessellation tessellate(const InkedSurface& surface, const std::vector<int>& vertices,
                        const std::vector<double>& areas, std::vector<Vector3d> sites, bool settle) {
  constexpr int most_iterations = 200;
  constexpr double settled_mm = 0.02;
  std::vector<std::size_t> cell(vertices.size());
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    std::vector<Vector3d> sum(sites.size(), Vector3d::Zero());
    std::vector<double> area(sites.size(), 0);
    in_parallel(0, static_cast<int>(vertices.size()), [&](int first, int last) {
      for (std::size_t i = index(first); i < index(last); ++i)
        cell[i] = nearest(sites, surface.inked()[index(vertices[i])]);
    });
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      sum[cell[i]] += areas[i] * surface.inked()[index(vertices[i])];
      area[cell[i]] += areas[i];
    }
    if (!settle) break;
    double moved = 0;
    for (std::size_t s = 0; s < sites.size(); ++s) {
      if (area[s] == 0) continue;
      const Vector3d middle = sum[s] / area[s];
      moved = std::max(moved, (middle - sites[s]).norm());
      sites[s] = middle;
    }
    if (moved < settled_mm) break;
  }
  Tessellation out;
  out.sites.assign(sites.size(), vertices.front());
  std::vector<double> least(sites.size(), std::numeric_limits<double>::infinity());
  std::vector<int> of_vertex(surface.inked().size(), -1);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    of_vertex[index(vertices[i])] = static_cast<int>(cell[i]);
    const double d = (surface.inked()[index(vertices[i])] - sites[cell[i]]).squaredNorm();
    if (d < least[cell[i]]) least[cell[i]] = d, out.sites[cell[i]] = vertices[i];
  }
  constexpr int shortest_border = 3;  // edges: cells that meet in little more than a point are not neighbours
  std::map<std::pair<int, int>, int> edges;
  for (const Triangle& t : surface.triangles())
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = of_vertex[index(t[k])], b = of_vertex[index(t[(k + 1) % 3])];
      if (a >= 0 && b >= 0 && a < b) ++edges[{a, b}];
    }
  for (const auto& [pair, count] : edges)
    if (count >= shortest_border) out.touch.push_back(pair);
  return out;
}

}  // namespace vacuform
