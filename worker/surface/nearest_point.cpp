#include "worker/surface/nearest_point.hpp"

#include <Eigen/Geometry>
#include <array>
#include <limits>

namespace vacuform {

namespace {

using Eigen::Vector3d;

// Weights of the point of the triangle that is nearest to p, in space.
Vector3d nearest_weights(const Vector3d& p, const std::array<Vector3d, 3>& corner) {
  const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  if (const double square = normal.squaredNorm(); square > 0) {
    Vector3d w;
    for (int k = 0; k < 3; ++k) {
      const Vector3d &b = corner[(k + 1) % 3], &c = corner[(k + 2) % 3];
      w[k] = (b - p).cross(c - p).dot(normal) / square;
    }
    if (w.minCoeff() >= 0) return w / w.sum();
  }
  Vector3d best = Vector3d::UnitX();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector3d &a = corner[k], &b = corner[(k + 1) % 3];
    const double f = nearest_on_edge(p, a, b), d = (a + f * (b - a) - p).squaredNorm();
    if (d >= least) continue;
    least = d;
    best.setZero();
    best[k] = 1 - f;
    best[(k + 1) % 3] = f;
  }
  return best;
}

}  // namespace

NearestPoint nearest_point(const std::vector<Triangle>& triangles, const std::vector<Vector3d>& places,
                           const std::vector<int>& which, const Vector3d& place) {
  NearestPoint best;
  best.distance_mm = std::numeric_limits<double>::infinity();
  for (const int t : which) {
    const Triangle& corners = triangles[t];
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = places[corners[k]];
    const Vector3d w = nearest_weights(place, p);
    const double d = (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] - place).norm();
    if (d < best.distance_mm) best = {{t, w}, d};
  }
  return best;
}

}  // namespace vacuform
