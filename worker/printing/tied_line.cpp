#include "worker/printing/tied_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double longest_reach_mm = 20;

// The part of the way from a to b at which p is nearest.
double nearest(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d d = b - a;
  return d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
}

// From 1 at 0 to 0 at 1, level at both.
double fade(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return 1 - x * x * x * (10 - 15 * x + 6 * x * x);
}

}  // namespace

double distance(const Vector2d& p, const Area& area) {
  double least = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (const Ring& ring : area)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
      least = std::min(least, (a + nearest(a, b, p) * (b - a) - p).norm());
      if ((a.y() > p.y()) != (b.y() > p.y()) &&
          p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
        inside = !inside;
    }
  return inside ? 0 : least;
}

TiedLine::TiedLine(std::vector<CurvePoint> line, double width_mm, const PatchMap& chart,
                   const PatchMap* start, const PatchMap* end)
    : line_(std::move(line)), beside_(width_mm), chart_(chart), ties_{tie(start, false), tie(end, true)} {}

// The element's patch need not reach as far as the line would pass over to the chart.
TiedLine::Tie TiedLine::tie(const PatchMap* map, bool from_end) const {
  if (!map) return {};
  const double length = line_.back().along;
  double reach = std::min(length / 2, longest_reach_mm);
  for (const CurvePoint& p : line_) {
    const double x = from_end ? length - p.along : p.along;
    if (x < reach && !map->rest_at(p.at, beside_ / 2)) reach = x;
  }
  return {reach > 0 ? map : nullptr, reach};
}

double TiedLine::along(const Vector2d& uv) const {
  double least = std::numeric_limits<double>::infinity(), out = 0;
  for (std::size_t i = 1; i < line_.size(); ++i) {
    const CurvePoint &a = line_[i - 1], &b = line_[i];
    const double f = nearest(a.at, b.at, uv), d = (a.at + f * (b.at - a.at) - uv).squaredNorm();
    if (d >= least) continue;
    least = d;
    out = a.along + f * (b.along - a.along);
  }
  return out;
}

std::optional<Vector2d> TiedLine::rest_at(const Vector2d& uv) const {
  auto rest = chart_.rest_at(uv);
  if (!rest) return rest;
  const double s = along(uv), length = line_.back().along;
  const Vector2d by_chart = *rest;
  for (std::size_t e = 0; e < 2; ++e) {
    const Tie& tie = ties_[e];
    const double x = e == 0 ? s : length - s;
    if (!tie.map || x >= tie.reach) continue;
    if (const auto own = tie.map->rest_at(uv, beside_)) *rest += fade(x / tie.reach) * (*own - by_chart);
  }
  return rest;
}

}  // namespace vacuform
