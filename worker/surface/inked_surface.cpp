#include "worker/surface/inked_surface.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace vacuform {

using Eigen::Vector2d;
using Eigen::Vector3d;

InkedSurface::InkedSurface(std::vector<Triangle> triangles, std::vector<Vector3d> inked,
                           std::vector<Vector2d> rest)
    : path_mesh_(std::move(triangles), std::move(inked)), rest_(std::move(rest)) {
  faces_.reserve(this->triangles().size());
  for (const Triangle& t : this->triangles()) {
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = this->inked()[t[k]];
    Face face{(p[1] - p[0]).cross(p[2] - p[0]), {}};
    const double square = face.normal.squaredNorm();
    for (std::size_t k = 0; k < 3; ++k)
      face.gradient[k] = square > 0 ? Vector3d(face.normal.cross(p[(k + 2) % 3] - p[(k + 1) % 3]) / square)
                                    : Vector3d(Vector3d::Zero());
    if (square > 0) face.normal /= std::sqrt(square);
    faces_.push_back(face);
  }
}

Vector3d InkedSurface::axis(int t, const std::vector<Vector2d>& flat) const {
  const Triangle& corners = triangles()[t];
  // Rows of the map from the triangle's plane to `flat`. The nearest rotation sends a + normal x b to (twice) the axis.
  Vector3d a = Vector3d::Zero(), b = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vector2d& at = flat[corners[static_cast<std::size_t>(k)]];
    a += at.x() * gradient(t, k);
    b += at.y() * gradient(t, k);
  }
  Vector3d axis = a - normal(t).cross(b);
  if (axis.squaredNorm() == 0) axis = normal(t).unitOrthogonal();
  return axis.normalized();
}

}  // namespace vacuform
