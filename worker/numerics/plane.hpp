// Vectors in the plane.
#pragma once

#include <Eigen/Core>

namespace vacuform {

// The z of the cross product: twice the area of the triangle (0, a, b), positive counter-clockwise.
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace vacuform
