// Fits cubic Beziers to points, as few as a tolerance allows. After P. Schneider 1990, "An algorithm for automatically
// fitting digitized curves", with tangents by differences of second order. Internal to worker/printing.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

struct FitPoint {
  Eigen::Vector2d at;
  bool corner = false;  // the curve may turn sharply here
};

// Smooth except at corners; every point lies within `tolerance_mm` of the curve. The last point of a closed curve is
// joined to the first. Fewer than two points give a curve without points. Deterministic.
Curve fit_curve(const std::vector<FitPoint>& points, bool closed, double tolerance_mm);

}  // namespace vacuform
