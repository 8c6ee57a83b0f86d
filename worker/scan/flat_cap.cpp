#include "worker/scan/cutting.hpp"
#include "worker/surface/planar_triangles.hpp"

namespace vacuform {

std::optional<std::vector<Triangle>> flat_cap(const std::vector<Eigen::Vector3d>& vertices,
                                              const std::vector<std::vector<int>>& loops) {
  std::vector<std::vector<Eigen::Vector2d>> rings;
  std::vector<int> number;  // of each point of the rings
  for (const auto& loop : loops) {
    rings.emplace_back();
    for (const int v : loop) {
      rings.back().push_back(vertices[v].head<2>());
      number.push_back(v);
    }
  }
  const PlanarTriangles cap = triangulate(rings);
  if (!cap.simple || cap.triangles.empty()) return std::nullopt;
  std::vector<Triangle> out;
  for (const auto& [a, b, c] : cap.triangles)  // turned over: the cap faces down
    out.push_back({number[a], number[c], number[b]});
  return out;
}

}  // namespace vacuform
