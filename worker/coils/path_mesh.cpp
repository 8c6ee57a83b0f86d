#include "worker/coils/path_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

namespace vacuform {

namespace {

using Eigen::Vector3d;

struct Edge {
  int low, high, side;
};

// Sorted by their ends: the two sides of an edge follow each other.
std::vector<Edge> edges_of(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]);
      edges.push_back({low, high, static_cast<int>(3 * t + k)});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return std::tie(x.low, x.high, x.side) < std::tie(y.low, y.high, y.side);
  });
  return edges;
}

}  // namespace

PathMesh::PathMesh(const std::vector<Triangle>& triangles, const std::vector<Vector3d>& places)
    : triangles_(triangles),
      places_(places),
      sides_(3 * triangles.size()),
      bends_(places.size(), 0),
      first_(places.size() + 1, 0),
      around_(3 * triangles.size()) {
  const std::vector<Edge> edges = edges_of(triangles);
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i == 2) {
      sides_[static_cast<std::size_t>(edges[i].side)].beyond = edges[i + 1].side;
      sides_[static_cast<std::size_t>(edges[i + 1].side)].beyond = edges[i].side;
    } else {
      bends_[static_cast<std::size_t>(edges[i].low)] = bends_[static_cast<std::size_t>(edges[i].high)] = 1;
    }
  }
  std::vector<double> angle(places.size(), 0);
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    const int t = static_cast<int>(s / 3), k = static_cast<int>(s % 3);
    const Vector3d &a = place(corner(t, k + 1)), &b = place(corner(t, k + 2)), &c = place(corner(t, k));
    Side& side = sides_[s];
    side.length = (b - a).norm();
    if (side.length > 0) {
      side.foot = (c - a).dot(b - a) / side.length;
      side.height = (c - a).cross(b - a).norm() / side.length;
    }
    angle[static_cast<std::size_t>(corner(t, k))] +=
        std::atan2((a - c).cross(b - c).norm(), (a - c).dot(b - c));
    ++first_[static_cast<std::size_t>(corner(t, k)) + 1];
  }
  constexpr double least_excess = 1e-10;  // below, what bends is less than rounding
  for (std::size_t v = 0; v < angle.size(); ++v) {
    if (angle[v] > 2 * M_PI + least_excess) bends_[v] = 1;
    first_[v + 1] += first_[v];
  }
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    const int v = corner(static_cast<int>(s / 3), static_cast<int>(s % 3));
    around_[static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++)] = static_cast<int>(s);
  }
}

std::vector<int> PathMesh::around(int vertex) const {
  const auto v = static_cast<std::size_t>(vertex);
  return {around_.begin() + first_[v], around_.begin() + first_[v + 1]};
}

}  // namespace vacuform
