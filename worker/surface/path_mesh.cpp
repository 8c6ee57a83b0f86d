#include "worker/surface/path_mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

}  // namespace

PathMesh::PathMesh(std::vector<Triangle> triangles, std::vector<Vector3d> places)
    : triangles_(std::move(triangles)),
      places_(std::move(places)),
      sides_(3 * triangles_.size()),
      total_angles_(places_.size(), 0) {
  const std::vector<int> opposite = opposite_sides(triangles_);
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    sides_[s].opposite = opposite[s];
    if (opposite[s] >= 0) continue;
    for (std::size_t end = 1; end < 3; ++end)
      total_angles_[triangles_[s / 3][(s % 3 + end) % 3]] = std::numeric_limits<double>::infinity();
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
    total_angles_[corner(t, k)] += angle(static_cast<int>(s));
  }
}

bool PathMesh::is_saddle(int vertex) const {
  constexpr double least_excess = 1e-10;  // a smaller excess bends a path less than rounding does
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
