#include "worker/scan/topology.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <tuple>

namespace vacuform {

std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), static_cast<int>(i), a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return uses;
}

bool is_watertight(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return false;
  const auto uses = edge_uses(mesh);
  for (std::size_t i = 0; i < uses.size(); i += 2) {
    if (i + 1 == uses.size() || uses[i].low == uses[i].high) return false;
    if (uses[i].low != uses[i + 1].low || uses[i].high != uses[i + 1].high) return false;
    if (uses[i].forward == uses[i + 1].forward) return false;
    if (i + 2 < uses.size() && uses[i].low == uses[i + 2].low && uses[i].high == uses[i + 2].high)
      return false;
  }
  return true;
}

std::vector<std::vector<int>> border_loops(const TriangleMesh& mesh) {
  const auto uses = edge_uses(mesh);
  std::vector<std::pair<int, int>> border;  // from, to: against the triangle that is there
  for (std::size_t i = 0, next; i < uses.size(); i = next) {
    for (next = i + 1;
         next < uses.size() && uses[next].low == uses[i].low && uses[next].high == uses[i].high;)
      ++next;
    if (next != i + 1) continue;
    if (uses[i].forward)
      border.emplace_back(uses[i].high, uses[i].low);
    else
      border.emplace_back(uses[i].low, uses[i].high);
  }
  std::sort(border.begin(), border.end());

  std::vector<std::vector<int>> loops;
  std::vector<char> taken(border.size(), 0);
  std::vector<int> place(mesh.vertices.size(), -1);  // of a vertex on the current path
  // The first unused edge of a vertex. Edges are used in order, so that none is examined twice.
  std::vector<std::size_t> next_of(mesh.vertices.size(), border.size());
  for (std::size_t i = border.size(); i-- > 0;) next_of[border[i].first] = i;
  const auto outgoing = [&](int vertex) {
    std::size_t& next = next_of[vertex];
    while (next < border.size() && border[next].first == vertex && taken[next]) ++next;
    return next < border.size() && border[next].first == vertex
               ? border.begin() + static_cast<std::ptrdiff_t>(next)
               : border.end();
  };
  std::vector<int> path;
  for (std::size_t start = 0; start < border.size(); ++start) {
    if (taken[start]) continue;
    path.assign(1, border[start].first);
    place[path.front()] = 0;
    while (!path.empty()) {
      const auto edge = outgoing(path.back());
      if (edge == border.end()) {  // a dead end: only where orientations clash
        place[path.back()] = -1;
        path.pop_back();
        continue;
      }
      taken[edge - border.begin()] = 1;
      const int to = edge->second;
      if (const int at = place[to]; at >= 0) {  // a loop has closed: take it off the path
        loops.emplace_back(path.begin() + at, path.end());
        for (std::size_t i = static_cast<std::size_t>(at) + 1; i < path.size(); ++i) place[path[i]] = -1;
        path.resize(static_cast<std::size_t>(at) + 1);
      } else {
        place[to] = static_cast<int>(path.size());
        path.push_back(to);
      }
    }
  }
  return loops;
}

int connected_pieces(const TriangleMesh& mesh, std::vector<int>& piece_of_triangle) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) {
      auto& p = parent[v];
      v = p = parent[p];
    }
    return v;
  };
  for (const auto& t : mesh.triangles) {
    const int a = root(t[0]);
    parent[root(t[1])] = a;
    parent[root(t[2])] = a;
  }
  std::vector<int> number(mesh.vertices.size(), -1);
  int pieces = 0;
  piece_of_triangle.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    int& n = number[root(mesh.triangles[i][0])];
    if (n < 0) n = pieces++;
    piece_of_triangle[i] = n;
  }
  return pieces;
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<int> number(mesh.vertices.size(), -1);
  for (const auto& t : mesh.triangles)
    for (const int v : t) number[v] = 0;
  int kept = 0;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] == 0) {
      mesh.vertices[kept] = mesh.vertices[v];
      number[v] = kept++;
    }
  mesh.vertices.resize(static_cast<std::size_t>(kept));
  for (auto& t : mesh.triangles)
    for (int& v : t) v = number[v];
}

TriangleMesh take_pieces(const TriangleMesh& mesh, const std::vector<int>& piece_of_triangle,
                         const std::vector<char>& keep) {
  TriangleMesh taken;
  taken.vertices = mesh.vertices;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (keep[piece_of_triangle[i]]) taken.triangles.push_back(mesh.triangles[i]);
  drop_unused_vertices(taken);
  return taken;
}

Box bounds(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Box box{mesh.vertices.front(), mesh.vertices.front()};
  for (const auto& p : mesh.vertices) box.low = box.low.cwiseMin(p), box.high = box.high.cwiseMax(p);
  return box;
}

double signed_volume(const TriangleMesh& mesh) {
  const Eigen::Vector3d centre = bounds(mesh).centre();
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]] - centre;
    volume += a.dot(area_vector(mesh, t)) / 3;
  }
  return volume;
}

}  // namespace vacuform
