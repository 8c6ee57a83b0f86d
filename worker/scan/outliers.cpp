#include "worker/scan/outliers.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "worker/scan/topology.hpp"
#include "worker/scan/welding.hpp"

namespace vacuform {

std::vector<Eigen::Vector3d> drop_outliers(TriangleMesh& mesh) {
  const Box middle = middle_box(mesh);
  const double reach = middle.size().norm();
  if (!(reach > 0)) return {};
  const auto away = [&](const Eigen::Vector3d& p) {
    return (p - p.cwiseMax(middle.low).cwiseMin(middle.high)).norm();
  };
  std::vector<char> far(mesh.vertices.size(), 0);
  std::vector<Eigen::Vector3d> places;
  for (std::size_t v = 0; v < far.size(); ++v)
    if (away(mesh.vertices[v]) > reach) far[v] = 1, places.push_back(mesh.vertices[v]);
  if (places.empty() || places.size() * 100 >= far.size()) return {};
  const auto stray = [&](const Triangle& t) { return far[t[0]] || far[t[1]] || far[t[2]]; };
  // If most of the surface is far away, that part is the scan, and what is in the middle is dust.
  double away_mm2 = 0, near_mm2 = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto corner = [&](int k) -> const Eigen::Vector3d& {
      return mesh.vertices[t[static_cast<std::size_t>(k)]];
    };
    const double mm2 = (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 2;
    const auto is_far = [&](int v) { return far[v] != 0; };
    if (std::all_of(t.begin(), t.end(), is_far))
      away_mm2 += mm2;
    else if (!stray(t))
      near_mm2 += mm2;
  }
  if (away_mm2 >= near_mm2) return {};
  std::erase_if(mesh.triangles, stray);
  drop_unused_vertices(mesh);
  std::stable_sort(places.begin(), places.end(),
                   [&](const auto& a, const auto& b) { return away(a) > away(b); });
  return places;
}

}  // namespace vacuform
