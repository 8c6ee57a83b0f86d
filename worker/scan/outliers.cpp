#include "worker/scan/outliers.hpp"

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
  const auto stray = [&](const Triangle& t) {
    return far[static_cast<std::size_t>(t[0])] || far[static_cast<std::size_t>(t[1])] ||
           far[static_cast<std::size_t>(t[2])];
  };
  if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(), stray)) return {};
  std::erase_if(mesh.triangles, stray);
  drop_unused_vertices(mesh);
  std::stable_sort(places.begin(), places.end(),
                   [&](const auto& a, const auto& b) { return away(a) > away(b); });
  return places;
}

}  // namespace vacuform
