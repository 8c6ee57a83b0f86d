#include "worker/placement/bent_mesh.hpp"

#include <algorithm>
#include <map>

#include "worker/stage/index.hpp"

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
    const auto count = std::count_if(cut.begin(), cut.end(), [](int v) { return v >= 0; });
    if (count == 0) continue;
    // Corners 0 to 2 are the old ones, 3 to 5 the middles after them.
    const std::array<int, 6> vertex{old[0], old[1], old[2], cut[0], cut[1], cut[2]};
    const std::array<Vector3d, 6> weights{
        w[0], w[1], w[2], (w[0] + w[1]) / 2, (w[1] + w[2]) / 2, (w[2] + w[0]) / 2};
    bool first = true;
    const auto put = [&](std::size_t a, std::size_t b, std::size_t c) {
      if (!first)
        mesh.triangles.push_back({}), mesh.corners.push_back({}), mesh.faces.push_back(mesh.faces[t]);
      const std::size_t at = first ? t : mesh.triangles.size() - 1;
      mesh.triangles[at] = {vertex[a], vertex[b], vertex[c]};
      mesh.corners[at] = {weights[a], weights[b], weights[c]};
      first = false;
    };
    const auto one = [&](auto which) {
      return static_cast<std::size_t>(std::find_if(cut.begin(), cut.end(), which) - cut.begin());
    };
    if (count == 3) {
      put(0, 3, 5), put(3, 1, 4), put(5, 4, 2), put(3, 4, 5);
    } else if (count == 2) {
      const std::size_t k = one([](int v) { return v < 0; }), m = (k + 1) % 3,
                        o = (k + 2) % 3;  // k to m is whole
      put(k, m, 3 + m), put(k, 3 + m, 3 + o), put(3 + o, 3 + m, o);
    } else {
      const std::size_t k = one([](int v) { return v >= 0; }), m = (k + 1) % 3, o = (k + 2) % 3;
      put(k, 3 + k, o), put(3 + k, m, o);
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
