#include "worker/scan/cutting.hpp"

#include <algorithm>
#include <cmath>

#include "worker/scan/topology.hpp"

namespace vacuform {

std::optional<TriangleMesh> cut_above(const TriangleMesh& mesh, double height) {
  constexpr double nearest = 1e-3;
  TriangleMesh cut;
  cut.vertices = mesh.vertices;
  bool whole = true;
  for (const auto& p : mesh.vertices) whole = whole && p.z() >= height;
  if (whole) return mesh;
  for (auto& p : cut.vertices)
    if (std::abs(p.z() - height) < nearest) p.z() = height + nearest;
  const auto above = [&](int v) { return cut.vertices[v].z() > height; };

  // One new vertex for each edge that crosses the plane.
  std::vector<std::pair<int, int>> crossing;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (above(a) != above(b)) crossing.emplace_back(std::min(a, b), std::max(a, b));
    }
  std::sort(crossing.begin(), crossing.end());
  crossing.erase(std::unique(crossing.begin(), crossing.end()), crossing.end());
  const std::size_t old_count = cut.vertices.size();
  cut.vertices.reserve(old_count + crossing.size());
  for (const auto& [a, b] : crossing) {
    const Eigen::Vector3d p = cut.vertices[a], q = cut.vertices[b];
    Eigen::Vector3d x = p + (q - p) * ((height - p.z()) / (q.z() - p.z()));
    x.z() = height;
    cut.vertices.push_back(x);
  }
  const auto crossing_of = [&](int a, int b) {
    const auto it =
        std::lower_bound(crossing.begin(), crossing.end(), std::pair{std::min(a, b), std::max(a, b)});
    return static_cast<int>(old_count + static_cast<std::size_t>(it - crossing.begin()));
  };
  for (const auto& t : mesh.triangles) {
    const int count = above(t[0]) + above(t[1]) + above(t[2]);
    if (count == 0) continue;
    if (count == 3) {
      cut.triangles.push_back(t);
      continue;
    }
    std::size_t k = 0;  // turn the triangle so that its odd corner out comes first
    while (above(t[k]) != (count == 1)) ++k;
    const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const int ab = crossing_of(a, b), ac = crossing_of(a, c);
    if (count == 1) {
      cut.triangles.push_back({a, ab, ac});
    } else {
      cut.triangles.push_back({ab, b, c});
      cut.triangles.push_back({ab, c, ac});
    }
  }
  drop_unused_vertices(cut);

  // Each piece is capped on its own: pieces may overlap, and their outlines then cross.
  std::vector<int> piece_of;
  const int pieces = connected_pieces(cut, piece_of);
  std::vector<int> piece_of_vertex(cut.vertices.size(), 0);
  for (std::size_t i = 0; i < cut.triangles.size(); ++i)
    for (const int v : cut.triangles[i]) piece_of_vertex[v] = piece_of[i];
  std::vector<std::vector<std::vector<int>>> loops(static_cast<std::size_t>(pieces));
  for (auto& loop : border_loops(cut)) {
    auto& of_piece = loops[piece_of_vertex[static_cast<std::size_t>(loop.front())]];
    of_piece.push_back(std::move(loop));
  }
  for (const auto& of_piece : loops) {
    if (of_piece.empty()) continue;
    const auto cap = flat_cap(cut.vertices, of_piece);
    if (!cap) return std::nullopt;
    cut.triangles.insert(cut.triangles.end(), cap->begin(), cap->end());
  }
  return cut;
}

}  // namespace vacuform
