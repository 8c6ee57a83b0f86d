#include "worker/printing/tied_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr std::size_t most_pieces = 8;  // of the line, in the smallest boxes

// The fraction of the way from a to b at which p is nearest.
double nearest(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d d = b - a;
  return d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
}

// From 1 at 0 to 0 at 1, level at both.
double fade(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return 1 - x * x * (3 - 2 * x);
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
    : line_(std::move(line)), beside_(width_mm), chart_(chart), ties_{tie(start, false), tie(end, true)} {
  if (line_.size() > 1) build(0, 1, line_.size());
}

TiedLine::Tie TiedLine::tie(const PatchMap* map, bool from_end) const {
  Tie out;
  for (std::size_t i = 0; map && i < line_.size(); ++i) {
    const CurvePoint& p = line_[from_end ? line_.size() - 1 - i : i];
    const auto own = map->rest_at(p.at, beside_ / 2), by_chart = chart_.rest_at(p.at);
    if (!own || !by_chart) break;
    out = {map, from_end ? line_.back().along - p.along : p.along, *own - *by_chart};
  }
  return out;
}

// Piece i joins points i - 1 and i.
void TiedLine::build(std::size_t node, std::size_t first, std::size_t last) {
  if (boxes_.size() <= node) boxes_.resize(node + 1);
  for (std::size_t i = first - 1; i < last; ++i) boxes_[node].extend(line_[i].at);
  if (last - first <= most_pieces) return;
  build(2 * node + 1, first, (first + last) / 2);
  build(2 * node + 2, (first + last) / 2, last);
}

// An upper bound of the squared distance to the nearest point.
double TiedLine::bound(const Vector2d& uv) const {
  std::size_t node = 0, first = 1, last = line_.size();
  while (last - first > most_pieces) {
    const bool right =
        boxes_[2 * node + 2].squaredExteriorDistance(uv) < boxes_[2 * node + 1].squaredExteriorDistance(uv);
    (right ? first : last) = (first + last) / 2;
    node = 2 * node + (right ? 2 : 1);
  }
  return (line_[first].at - uv).squaredNorm() * (1 + 1e-9) + 1e-18;
}

void TiedLine::look(std::size_t node, std::size_t first, std::size_t last, const Vector2d& uv,
                    Nearest& best) const {
  if (boxes_[node].squaredExteriorDistance(uv) > best.square * (1 + 1e-9) + 1e-18) return;
  if (last - first > most_pieces) {
    look(2 * node + 1, first, (first + last) / 2, uv, best);
    look(2 * node + 2, (first + last) / 2, last, uv, best);
    return;
  }
  for (std::size_t i = first; i < last; ++i) {
    const CurvePoint &a = line_[i - 1], &b = line_[i];
    const double f = nearest(a.at, b.at, uv), d = (a.at + f * (b.at - a.at) - uv).squaredNorm();
    if (d < best.square) best = {d, a.along + f * (b.along - a.along)};
  }
}

// If several points are equally near, the first on the line.
double TiedLine::along(const Vector2d& uv) const {
  if (line_.size() < 2) return 0;
  Nearest best{bound(uv), 0};
  look(0, 1, line_.size(), uv, best);
  return best.along;
}

Vector2d TiedLine::moved(const Tie& tie, double x, const Vector2d& uv, const Vector2d& by_chart) const {
  if (tie.map && x < tie.reach)
    if (const auto own = tie.map->rest_at(uv, beside_))
      return tie.beyond + fade(x / tie.reach) * (*own - by_chart - tie.beyond);
  return tie.beyond;
}

std::optional<Vector2d> TiedLine::rest_at(const Vector2d& uv) const {
  const auto by_chart = chart_.rest_at(uv);
  if (!by_chart) return by_chart;
  const double s = along(uv), length = line_.back().along, of_start = fade(s / length);
  return *by_chart + of_start * moved(ties_[0], s, uv, *by_chart) +
         (1 - of_start) * moved(ties_[1], length - s, uv, *by_chart);
}

}  // namespace vacuform
