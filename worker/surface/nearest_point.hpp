// The point of some triangles in space that is nearest to a place.
#pragma once

#include <algorithm>
#include <vector>

#include "worker/surface/sheet_point.hpp"

namespace vacuform {

struct NearestPoint {
  SheetPoint point{};
  double distance_mm = 0;  // infinite without triangles
};
// The nearest point of the triangles `which`; if several are equally near, on the first. Linear in their number.
NearestPoint nearest_point(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& places,
                           const std::vector<int>& which, const Eigen::Vector3d& place);

// Fraction along a to b, in [0, 1], of the point nearest to p.
template <class V>
double nearest_on_edge(const V& p, const V& a, const V& b) {
  const double square = (b - a).squaredNorm();
  return square > 0 ? std::clamp((p - a).dot(b - a) / square, 0.0, 1.0) : 0;
}

}  // namespace vacuform
