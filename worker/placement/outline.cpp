#include "worker/placement/outline.hpp"

#include <algorithm>
#include <cmath>

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

// Of a loop: what is computed of two loops takes the points of one times those of the other.
constexpr std::size_t enough_points = 96, most_points = 480;

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

double equal_radius(double area_mm2) { return std::sqrt(std::abs(area_mm2) / M_PI); }

// How far the ink of a line lies from its middle at most: corners, and the corners of square caps.
double half_width(const Stroke& stroke) {
  const double corner =
      stroke.join == LineJoin::miter ? std::clamp(stroke.miter_limit, M_SQRT2, 4.0) : M_SQRT2;
  return 0.5 * widest_mm(stroke) * corner;
}

}  // namespace

Outline outline(const Element& element, double scale) {
  Outline out;
  const auto drawn = drawn_loop(element);
  double largest = 0, second = 0;
  bool filled_only = false;
  for (const Shape& shape : element.shapes)
    for (const Curve& curve : shape.curves) {
      Polyline line = sampled(curve, element.centre, scale);
      out.points.insert(out.points.end(), line.begin(), line.end());
      const double beyond = shape.stroke ? scale * half_width(*shape.stroke) : 0;
      for (const Vector2d& p : line) out.reach_mm = std::max(out.reach_mm, p.norm() + beyond);
      if (!curve.closed || line.size() < 3) continue;
      const double size = std::abs(signed_area(line));
      if (size <= largest) {
        second = std::max(second, size);
        continue;
      }
      second = largest;
      largest = size;
      filled_only = !shape.stroke;
      out.width_mm = shape.stroke ? scale * shape.stroke->width_mm : scale;
      if (signed_area(line) < 0) std::reverse(line.begin(), line.end());
      out.loop = std::move(line);
    }
  if (drawn && drawn->kind != DrawnLoop::Kind::closed_line) {
    out.loop = evenly(drawn->line, enough_points);
    if (signed_area(out.loop) < 0) std::reverse(out.loop.begin(), out.loop.end());
    for (Vector2d& p : out.loop) p = scale * (p - element.centre);
    out.radius_mm = scale * equal_radius(drawn->area_mm2);
    out.width_mm = scale * drawn->width_mm;
    return out;
  }
  if (out.loop.empty()) {
    out.radius_mm = out.reach_mm;
    return out;
  }
  if (out.loop.size() > most_points) out.loop = evenly(out.loop, most_points);
  out.radius_mm = equal_radius(largest);
  if (const double inner = equal_radius(second); filled_only && inner > 0.5 * out.radius_mm) {
    const double middle = 0.5 * (out.radius_mm + inner);
    out.width_mm = out.radius_mm - inner;
    for (Vector2d& p : out.loop) p *= middle / out.radius_mm;
    out.radius_mm = middle;
  }
  return out;
}

}  // namespace vacuform
