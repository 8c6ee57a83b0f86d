#include "worker/placement/outline.hpp"

#include <algorithm>
#include <cmath>

#include "worker/numerics/plane.hpp"
#include "worker/pattern/drawn_loop.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Polyline = std::vector<Vector2d>;

// Each segment in pieces, so that the whole has a hundred or so; the last point of a closed curve is left out.
Polyline sampled(const Curve& curve, const Vector2d& centre, double scale) {
  Polyline out;
  const int segments = static_cast<int>(curve.points.size()) / 3;
  const int pieces = std::max(4, (96 + segments - 1) / std::max(1, segments));
  for (int s = 0; s < segments; ++s) {
    const Vector2d* p = curve.points.data() + 3 * s;
    for (int k = 0; k < pieces; ++k) {
      const double t = static_cast<double>(k) / pieces, u = 1 - t;
      out.push_back(scale * (u * u * u * p[0] + 3 * u * u * t * p[1] + 3 * u * t * t * p[2] +
                             t * t * t * p[3] - centre));
    }
  }
  if (!curve.points.empty() && !curve.closed) out.push_back(scale * (curve.points.back() - centre));
  return out;
}

// Enough for a circle, and more for a loop that winds. What is computed of two loops takes the points of one times those
// of the other.
std::size_t points_for(const Polyline& line) {
  constexpr std::size_t enough = 96, most = 480;
  double turned = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector2d before = line[(i + 1) % line.size()] - line[i],
                   after = line[(i + 2) % line.size()] - line[(i + 1) % line.size()];
    turned += std::abs(std::atan2(cross(before, after), before.dot(after)));
  }
  const auto rounds = static_cast<std::size_t>(std::ceil(turned / (2 * M_PI) - 0.5));
  return std::clamp(enough * rounds, enough, most);
}

// So many points at equal distances along a closed line.
Polyline evenly(const Polyline& line, std::size_t count) {
  const auto piece = [&](std::size_t i) -> Vector2d { return line[(i + 1) % line.size()] - line[i]; };
  double around = 0, along = 0;
  for (std::size_t i = 0; i < line.size(); ++i) around += piece(i).norm();
  Polyline out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double length = piece(i).norm();
    for (double at = 0; out.size() < count; out.push_back(line[i] + at / length * piece(i)))
      if (at = around * static_cast<double>(out.size()) / static_cast<double>(count) - along; at >= length)
        break;
    along += length;
  }
  return out;
}

// How far the ink of a line lies from its middle at most: corners, and the corners of square caps.
double half_width(const Stroke& stroke) {
  const double corner =
      stroke.join == LineJoin::miter ? std::clamp(stroke.miter_limit, M_SQRT2, 4.0) : M_SQRT2;
  return 0.5 * widest_mm(stroke) * corner;
}

}  // namespace

Outline outline(const Element& element, double scale) {
  Outline out;
  for (const Shape& shape : element.shapes)
    for (const Curve& curve : shape.curves) {
      const Polyline line = sampled(curve, element.centre, scale);
      out.points.insert(out.points.end(), line.begin(), line.end());
      const double beyond = shape.stroke ? scale * half_width(*shape.stroke) : 0;
      for (const Vector2d& p : line) out.reach_mm = std::max(out.reach_mm, p.norm() + beyond);
    }
  out.radius_mm = out.reach_mm;
  if (!element.loop) return out;
  const DrawnLoop& loop = *element.loop;
  out.loop = evenly(loop.line, points_for(loop.line));
  if (signed_area(out.loop) < 0) std::reverse(out.loop.begin(), out.loop.end());
  for (Vector2d& p : out.loop) p = scale * (p - element.centre);
  out.radius_mm = scale * std::sqrt(loop.area_mm2 / M_PI);
  out.width_mm = scale * loop.width_mm;
  return out;
}

}  // namespace vacuform
