#include "worker/conductors/loop_path.hpp"

#include <algorithm>
#include <cmath>

namespace vacuform {

using Eigen::Vector2d;

LoopPath::LoopPath(const DrawnLoop& loop) : points_(loop.line), width_(loop.width_mm) {
  points_.push_back(loop.line.front());
  along_.push_back(0);
  for (std::size_t i = 1; i < points_.size(); ++i)
    along_.push_back(along_.back() + (points_[i] - points_[i - 1]).norm());
}

double LoopPath::round(double along) const {
  const double rest = along - length() * std::floor(along / length());
  return rest < length() ? rest : 0;
}

std::size_t LoopPath::piece(double along) const {
  const auto after = std::upper_bound(along_.begin() + 1, along_.end() - 1, along);
  return static_cast<std::size_t>(after - along_.begin()) - 1;
}

Vector2d LoopPath::at(double along) const {
  const double x = round(along);
  const std::size_t i = piece(x);
  const double all = along_[i + 1] - along_[i];
  return all > 0 ? Vector2d(points_[i] + (x - along_[i]) / all * (points_[i + 1] - points_[i])) : points_[i];
}

Curve LoopPath::part(double from, double to) const {
  const double begin = round(from), end = begin + (to - from);
  std::vector<Vector2d> line{at(begin)};
  const std::size_t pieces = points_.size() - 1;
  for (std::size_t i = piece(begin) + 1;; ++i) {
    const std::size_t rounds = i / pieces;
    const double next = along_[i % pieces] + length() * static_cast<double>(rounds);
    if (next >= end) break;
    line.push_back(points_[i % pieces]);
  }
  line.push_back(at(end));
  return straight_curve(line);
}

double apart_on_loop(double a, double b, double length) {
  const double way = std::abs(a - b) - length * std::floor(std::abs(a - b) / length);
  return std::min(way, length - way);
}

Curve straight_curve(const std::vector<Vector2d>& points) {
  Curve out;
  for (const Vector2d& p : points) {
    if (!out.points.empty()) {
      const Vector2d from = out.points.back();
      out.points.push_back(from + (p - from) / 3);
      out.points.push_back(from + (p - from) * 2 / 3);
    }
    out.points.push_back(p);
  }
  return out;
}

}  // namespace vacuform
