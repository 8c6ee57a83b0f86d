#include "worker/placement/bent_mesh.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "worker/stage/index.hpp"
#include "worker/surface/split_triangle.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// One round. Returns whether any edge was cut.
bool halve(BentMesh& mesh, const std::function<double(const SheetPoint&)>& radius_at, double reach_mm,
           double tolerance_mm) {
  std::map<std::pair<int, int>, int> middles;  // of edges: the vertex there, -1 where it is not cut
  const auto middle = [&](std::size_t t, std::size_t k) {
    const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
    const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), -1);
    if (!is_new || std::min(mesh.radius[index(a)], mesh.radius[index(b)]) > reach_mm) return found->second;
    const double radius = radius_at({mesh.faces[t], (mesh.corners[t][k] + mesh.corners[t][(k + 1) % 3]) / 2});
    mesh.flat.push_back((mesh.flat[index(a)] + mesh.flat[index(b)]) / 2);
    mesh.radius.push_back(radius);
    const int vertex = static_cast<int>(mesh.flat.size()) - 1;
    const Vector2d beside = mesh.mapped(vertex) - (mesh.mapped(a) + mesh.mapped(b)) / 2;
    if (!(beside.norm() > tolerance_mm)) {
      mesh.flat.pop_back(), mesh.radius.pop_back();
      return -1;
    }
    mesh.rest.push_back((mesh.rest[index(a)] + mesh.rest[index(b)]) / 2);
    mesh.inked.push_back((mesh.inked[index(a)] + mesh.inked[index(b)]) / 2);
    return found->second = vertex;
  };

  const std::size_t before = mesh.triangles.size();
  for (std::size_t t = 0; t < before; ++t) {
    const Triangle old = mesh.triangles[t];
    const std::array<Vector3d, 3> w = mesh.corners[t];
    const std::array<int, 3> cut{middle(t, 0), middle(t, 1), middle(t, 2)};
    // Corners 0 to 2 are the old ones, 3 to 5 the middles after them.
    const std::array<int, 6> vertex{old[0], old[1], old[2], cut[0], cut[1], cut[2]};
    const std::array<Vector3d, 6> weights{
        w[0], w[1], w[2], (w[0] + w[1]) / 2, (w[1] + w[2]) / 2, (w[2] + w[0]) / 2};
    const auto place = [&](std::size_t k) { return cut[k] < 0 ? -1 : static_cast<int>(3 + k); };
    std::size_t at = t;
    for (const Triangle& piece : pieces_of({0, 1, 2}, {place(0), place(1), place(2)})) {
      if (at > t)
        mesh.triangles.push_back(piece), mesh.corners.push_back(w), mesh.faces.push_back(mesh.faces[t]);
      for (std::size_t k = 0; k < 3; ++k) {
        mesh.triangles[at][k] = vertex[index(piece[k])];
        mesh.corners[at][k] = weights[index(piece[k])];
      }
      at = mesh.triangles.size();
    }
  }
  return mesh.triangles.size() > before;
}

}  // namespace

Vector2d BentMesh::mapped(int vertex) const {
  const Vector2d& d = flat[index(vertex)];
  const double length = d.norm();
  return length > 0 ? Vector2d(radius[index(vertex)] / length * d) : Vector2d(0, 0);
}

void refine(BentMesh& mesh, const std::function<double(const SheetPoint&)>& radius_at, double reach_mm,
            double tolerance_mm) {
  constexpr int most_rounds = 3;
  for (int round = 0; round < most_rounds && halve(mesh, radius_at, reach_mm, tolerance_mm); ++round)
    continue;
}

}  // namespace vacuform
