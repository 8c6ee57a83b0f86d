// Cubic Bezier curves as points close enough to be joined by straight lines.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// The smallest box around the curve itself, not around its control points.
Eigen::AlignedBox2d box_of(const Curve& curve);

// How far the curve turns, in radians. Each segment, with the corner before it, counts as at most 1.
double turns(const Curve& curve);

// Counter-clockwise, in four segments; within 3e-4 of the radius.
Curve circle(const Eigen::Vector2d& centre, double radius);

struct CurvePoint {
  Eigen::Vector2d at;
  Eigen::Vector2d before, after;  // unit tangents; they differ at corners. Zero on a curve without length
  double along = 0;               // length from the curve's start, mm
};

// How finely a curve is followed.
struct Fineness {
  double tolerance_mm = 0.002;  // between a chord and the curve
  double turn = 0.2;            // between the tangents at a chord's ends, radians
  double longest_mm = 1e9;      // of a chord
};

// Points along the curve from its start to its end; for a closed curve the first point is repeated as the last. At most
// 4096 chords a segment, whatever the fineness. Points that coincide are one.
std::vector<CurvePoint> flatten(const Curve& curve, const Fineness& fineness);

}  // namespace vacuform
