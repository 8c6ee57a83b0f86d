// A point of a triangulated surface, and linear interpolation in its triangles.
#pragma once

#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A triangle and weights of its corners that sum to 1.
struct SheetPoint {
  int triangle;
  Eigen::Vector3d weights;
};

// The value at a point of values per vertex.
template <class Values>
auto interpolate(const std::vector<Triangle>& triangles, const SheetPoint& at, const Values& values) {
  const Triangle& t = triangles[at.triangle];
  using Value = std::decay_t<decltype(values[0])>;
  return Value(at.weights[0] * values[t[0]] + at.weights[1] * values[t[1]] + at.weights[2] * values[t[2]]);
}

}  // namespace vacuform
