#include "worker/surface/path_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double infinite = std::numeric_limits<double>::infinity();

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

PathMesh::PathMesh(std::vector<Triangle> triangles, std::vector<Vector3d> places)
    : triangles_(std::move(triangles)),
      places_(std::move(places)),
      sides_(3 * triangles_.size()),
      total_angles_(places_.size(), 0) {
  const std::vector<Edge> edges = edges_of(triangles_);
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i == 2) {
      sides_[static_cast<std::size_t>(edges[i].side)].opposite = edges[i + 1].side;
      sides_[static_cast<std::size_t>(edges[i + 1].side)].opposite = edges[i].side;
    } else {
      total_angles_[static_cast<std::size_t>(edges[i].low)] =
          total_angles_[static_cast<std::size_t>(edges[i].high)] = infinite;
    }
  }
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    const int t = static_cast<int>(s / 3), k = static_cast<int>(s % 3);
    const Vector3d &a = place(corner(t, k + 1)), &b = place(corner(t, k + 2)), &c = place(corner(t, k));
    Side& side = sides_[s];
    side.length = (b - a).norm();
    if (side.length > 0) {
      side.foot = (c - a).dot(b - a) / side.length;
      side.height = (c - a).cross(b - a).norm() / side.length;
    }
    total_angles_[static_cast<std::size_t>(corner(t, k))] += angle(static_cast<int>(s));
  }
}

bool PathMesh::is_saddle(int vertex) const {
  constexpr double least_excess = 1e-10;  // below, what bends is less than rounding
  return total_angle(vertex) > 2 * M_PI + least_excess;
}

double PathMesh::angle(int s) const {
  const Side& it = side(s);
  return std::atan2(it.height * it.length, it.height * it.height - it.foot * (it.length - it.foot));
}

int PathMesh::next_around(int s, bool counter_clockwise) const {
  const int t = s / 3, k = s % 3;
  const int opposite = side(3 * t + (k + (counter_clockwise ? 1 : 2)) % 3).opposite;
  if (opposite < 0) return -1;
  return 3 * (opposite / 3) + (opposite % 3 + (counter_clockwise ? 1 : 2)) % 3;
}

}  // namespace vacuform
