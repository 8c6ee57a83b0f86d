#include "worker/pattern/curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Cubic = std::array<Vector2d, 4>;

Vector2d point(const Cubic& c, double t) {
  const double s = 1 - t;
  return s * s * s * c[0] + 3 * s * s * t * c[1] + 3 * s * t * t * c[2] + t * t * t * c[3];
}

// Where control points coincide the next ones give the direction.
Vector2d start_tangent(const Cubic& c) {
  for (std::size_t k = 1; k < 4; ++k)
    if (const Vector2d d = c[k] - c[0]; d.norm() > 1e-12) return d.normalized();
  return Vector2d::Zero();
}
Vector2d end_tangent(const Cubic& c) {
  for (std::size_t k = 3; k-- > 0;)
    if (const Vector2d d = c[3] - c[k]; d.norm() > 1e-12) return d.normalized();
  return Vector2d::Zero();
}

class Flattener {
 public:
  Flattener(const Fineness& fineness, std::vector<CurvePoint>& out) : fineness_(fineness), out_(out) {}

  void segment(const Cubic& c) {
    const Vector2d tangent = start_tangent(c);
    if (out_.empty())
      out_.push_back({c[0], tangent, tangent, 0});
    else if (!tangent.isZero())
      out_.back().after = tangent;
    divide(c, 0);
  }

 private:
  bool straight_enough(const Cubic& c) const {
    const Vector2d chord = c[3] - c[0];
    if (chord.norm() > fineness_.longest_mm) return false;
    const double bend = std::max((c[0] - 2 * c[1] + c[2]).norm(), (c[1] - 2 * c[2] + c[3]).norm());
    // A cubic lies within 3/4 of its largest second difference from its chord.
    if (0.75 * bend > fineness_.tolerance_mm) return false;
    return start_tangent(c).dot(end_tangent(c)) > std::cos(fineness_.turn) || chord.norm() < 1e-6;
  }

  void divide(const Cubic& c, int depth) {
    if (depth == 12 || straight_enough(c)) return end(c);
    const Vector2d a = (c[0] + c[1]) / 2, m = (c[1] + c[2]) / 2, b = (c[2] + c[3]) / 2;
    const Vector2d am = (a + m) / 2, mb = (m + b) / 2, middle = (am + mb) / 2;
    divide({c[0], a, am, middle}, depth + 1);
    divide({middle, mb, b, c[3]}, depth + 1);
  }

  void end(const Cubic& c) {
    const double step = (c[3] - out_.back().at).norm();
    if (step < 1e-9) return;
    const Vector2d tangent = end_tangent(c);
    out_.push_back({c[3], tangent, tangent, out_.back().along + step});
  }

  const Fineness& fineness_;
  std::vector<CurvePoint>& out_;
};

}  // namespace

Eigen::AlignedBox2d box_of(const Curve& curve) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i + 3 < curve.points.size(); i += 3) {
    const Cubic c{curve.points[i], curve.points[i + 1], curve.points[i + 2], curve.points[i + 3]};
    box.extend(c[0]);
    box.extend(c[3]);
    for (int axis = 0; axis < 2; ++axis) {
      // The derivative is 3 (p t^2 + 2 q t + r).
      const double r = c[1][axis] - c[0][axis], q = c[2][axis] - 2 * c[1][axis] + c[0][axis];
      const double p = c[3][axis] - 3 * c[2][axis] + 3 * c[1][axis] - c[0][axis];
      const double root = std::sqrt(std::max(0.0, q * q - p * r));
      // Both roots without cancellation: r / -(q +- root) and -(q +- root) / p.
      const double far = -(q + std::copysign(root, q));
      for (const double t : {r / far, far / p})
        if (t > 0 && t < 1) box.extend(point(c, t));
    }
  }
  return box;
}

Curve circle(const Vector2d& centre, double radius) {
  const double k = 4.0 / 3 * (std::sqrt(2.0) - 1);
  Curve out{{centre + Vector2d(radius, 0)}, true};
  for (const auto& [x, y] : {std::pair{1., 0.}, {0., 1.}, {-1., 0.}, {0., -1.}}) {
    const Vector2d from(x, y), to(-y, x);
    for (const Vector2d& p : {Vector2d(from + k * to), Vector2d(to + k * from), to})
      out.points.push_back(centre + radius * p);
  }
  return out;
}

double turns(const Curve& curve) {
  double out = 0, of_segment = 0;
  Vector2d before(0, 0);
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    const Vector2d way = curve.points[i] - curve.points[i - 1];
    if (!way.isZero(0)) {
      const double sine = cross(before, way);
      if (!before.isZero(0)) of_segment += std::atan2(std::abs(sine), before.dot(way));
      before = way;
    }
    if (i % 3 != 0) continue;
    out += std::min(of_segment, 1.0);
    of_segment = 0;
  }
  return out;
}

std::vector<CurvePoint> flatten(const Curve& curve, const Fineness& fineness) {
  std::vector<CurvePoint> out;
  Flattener flattener(fineness, out);
  const auto& p = curve.points;
  for (std::size_t i = 0; i + 3 < p.size(); i += 3) flattener.segment({p[i], p[i + 1], p[i + 2], p[i + 3]});
  if (curve.closed && out.size() > 1) {
    out.front().before = out.back().before;
    out.back().after = out.front().after;
  }
  return out;
}

}  // namespace vacuform
