#include "worker/printing/curve_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Cubic = std::array<Vector2d, 4>;

constexpr double reach_mm = 0.3;             // length over which differences give the tangents
constexpr std::size_t most_points = 20'000;  // more are divided before a curve is tried

Vector2d at(const Cubic& c, double t) {
  const double s = 1 - t;
  return s * s * s * c[0] + 3 * s * s * t * c[1] + 3 * s * t * t * c[2] + t * t * t * c[3];
}

class Fitter {
 public:
  Fitter(const std::vector<Vector2d>& points, double tolerance, std::vector<Vector2d>& out)
      : points_(points), tolerance_(tolerance), out_(out) {
    along_.push_back(0);
    for (std::size_t i = 1; i < points.size(); ++i)
      along_.push_back(along_.back() + (points[i] - points[i - 1]).norm());
  }

  // From points[first] to points[last]; `start` and `end` are the tangents there, both into the curve.
  void fit(std::size_t first, std::size_t last, const Vector2d& start, const Vector2d& end) {
    if (last - first == 1) return straight(first, last);
    if (last - first > most_points) return divide(first, last, (first + last) / 2, start, end);
    parameters_.resize(last - first + 1);
    for (std::size_t i = first; i <= last; ++i)
      parameters_[i - first] = (along_[i] - along_[first]) / (along_[last] - along_[first]);
    std::size_t worst = first;
    for (int round = 0; round < 5; ++round) {
      const Cubic c = least_squares(first, last, start, end);
      const double error = farthest(c, first, last, worst);
      if (error <= tolerance_) {
        out_.insert(out_.end(), {c[1], c[2], c[3]});
        return;
      }
      if (error > 16 * tolerance_) break;  // better parameters cannot correct that
      improve(c, first, last);
    }
    divide(first, last, std::clamp(worst, first + 1, last - 1), start, end);
  }

  // The tangent at the end `from`, into the curve; uses no point beyond `limit`.
  Vector2d end_tangent(std::size_t from, std::size_t limit) const {
    const double length = std::abs(along_[limit] - along_[from]);
    const std::size_t near = away(from, limit, std::min(reach_mm, length / 2));
    const std::size_t far = away(from, limit, std::min(2 * reach_mm, length));
    const double a = std::abs(along_[near] - along_[from]), b = std::abs(along_[far] - along_[from]);
    Vector2d d = points_[near] - points_[from];
    if (b > a && a > 0)
      d = (b * b * (points_[near] - points_[from]) - a * a * (points_[far] - points_[from])) /
          (a * b * (b - a));
    return d.norm() > 0 ? Vector2d(d.normalized()) : Vector2d(1, 0);
  }

 private:
  void divide(std::size_t first, std::size_t last, std::size_t at, const Vector2d& start,
              const Vector2d& end) {
    const Vector2d middle = tangent(at, first, last);
    fit(first, at, start, -middle);
    fit(at, last, middle, end);
  }

  void straight(std::size_t first, std::size_t last) {
    const Vector2d &a = points_[first], &b = points_[last];
    out_.insert(out_.end(), {a + (b - a) / 3, b - (b - a) / 3, b});
  }

  // The point about `reach` from `from` towards `limit`, at least the next one.
  std::size_t away(std::size_t from, std::size_t limit, double reach) const {
    const bool forward = limit > from;
    std::size_t i = from;
    do forward ? ++i : --i;
    while (i != limit && std::abs(along_[i] - along_[from]) < reach);
    return i;
  }

  Vector2d tangent(std::size_t i, std::size_t first, std::size_t last) const {
    const double room = std::min({reach_mm, along_[i] - along_[first], along_[last] - along_[i]});
    const Vector2d d = points_[away(i, last, room)] - points_[away(i, first, room)];
    return d.norm() > 0 ? Vector2d(d.normalized()) : Vector2d(1, 0);
  }

  Cubic least_squares(std::size_t first, std::size_t last, const Vector2d& start, const Vector2d& end) const {
    const Vector2d &p = points_[first], &q = points_[last];
    double c00 = 0, c01 = 0, c11 = 0, x0 = 0, x1 = 0;
    for (std::size_t i = first; i <= last; ++i) {
      const double t = parameters_[i - first], s = 1 - t;
      const Vector2d a = 3 * s * s * t * start, b = 3 * s * t * t * end;
      const Vector2d rest = points_[i] - (s * s * s + 3 * s * s * t) * p - (t * t * t + 3 * s * t * t) * q;
      c00 += a.dot(a);
      c01 += a.dot(b);
      c11 += b.dot(b);
      x0 += a.dot(rest);
      x1 += b.dot(rest);
    }
    const double determinant = c00 * c11 - c01 * c01, length = (q - p).norm();
    double l0 = 0, l1 = 0;
    if (std::abs(determinant) > 1e-12 * c00 * c11) {
      l0 = (x0 * c11 - x1 * c01) / determinant;
      l1 = (c00 * x1 - c01 * x0) / determinant;
    }
    // Handles that point backwards, or that pass each other, fold the curve between two points: a third of the length is used
    // instead.
    const double least = 1e-6 * length, along = along_[last] - along_[first];
    if (!(l0 > least && l1 > least && l0 + l1 < along)) l0 = l1 = along / 3;
    return {p, p + l0 * start, q + l1 * end, q};
  }

  double farthest(const Cubic& c, std::size_t first, std::size_t last, std::size_t& worst) const {
    double most = 0;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double d = (at(c, parameters_[i - first]) - points_[i]).squaredNorm();
      if (d <= most) continue;
      most = d;
      worst = i;
    }
    return std::sqrt(most);
  }

  // A step of Newton's towards each point's nearest parameter.
  void improve(const Cubic& c, std::size_t first, std::size_t last) {
    double before = 0;
    for (std::size_t i = first + 1; i < last; ++i) {
      double& t = parameters_[i - first];
      const double s = 1 - t;
      const Vector2d d = at(c, t) - points_[i];
      const Vector2d v = 3 * (s * s * (c[1] - c[0]) + 2 * s * t * (c[2] - c[1]) + t * t * (c[3] - c[2]));
      const Vector2d w = 6 * (s * (c[2] - 2 * c[1] + c[0]) + t * (c[3] - 2 * c[2] + c[1]));
      const double slope = v.squaredNorm() + d.dot(w);
      if (slope > 0) t = std::clamp(t - d.dot(v) / slope, before, 1.0);
      before = t;
    }
  }

  const std::vector<Vector2d>& points_;
  const double tolerance_;
  std::vector<Vector2d>& out_;
  std::vector<double> along_, parameters_;
};

}  // namespace

Curve fit_curve(const std::vector<FitPoint>& given, bool closed, double tolerance_mm) {
  // A closed curve begins at a corner if it has one.
  std::size_t start = 0;
  if (closed)
    while (start + 1 < given.size() && !given[start].corner) ++start;
  if (!given.empty() && !given[start].corner) start = 0;
  std::vector<Vector2d> points;
  std::vector<std::size_t> ends{0};
  const std::size_t n = given.size(), count = closed && n > 0 ? n + 1 : n;
  for (std::size_t k = 0; k < count; ++k) {
    const FitPoint& p = given[(start + k) % n];
    if (!points.empty() && (p.at - points.back()).norm() < 1e-7) {
      if (p.corner && ends.back() + 1 < points.size()) ends.push_back(points.size() - 1);
      continue;
    }
    points.push_back(p.at);
    if (p.corner && points.size() > 1) ends.push_back(points.size() - 1);
  }
  Curve curve;
  curve.closed = closed;
  if (points.size() < 2) return curve;
  if (ends.back() + 1 != points.size()) ends.push_back(points.size() - 1);
  if (closed) points.back() = points.front();

  curve.points.push_back(points.front());
  Fitter fitter(points, tolerance_mm, curve.points);
  const bool smooth_all_round = closed && !given[start].corner;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const std::size_t a = ends[k], b = ends[k + 1];
    Vector2d from = fitter.end_tangent(a, b), to = fitter.end_tangent(b, a);
    if (smooth_all_round && a == 0 && b + 1 == points.size()) {
      const Vector2d mean = from - to;
      if (mean.norm() > 0.1) {
        from = mean.normalized();
        to = -from;
      }
    }
    fitter.fit(a, b, from, to);
  }
  return curve;
}

}  // namespace vacuform
