#include "worker/conductors/part_line.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/pattern/drawn_loop.hpp"
#include "worker/surface/geodesic.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The sheet's triangles bend the line a little at each of their edges: its direction is that over this length to both sides.
constexpr double direction_mm = 1;

}  // namespace

PartLine::PartLine(const InkedSurface& surface, const PlaneLocator& locator,
                   const std::vector<Vector2d>& line)
    : surface_(surface), locator_(locator) {
  for (const Vector2d& p : line) {
    const auto found = locator.find(p);
    if (!found) continue;
    Point& point = points_.emplace_back(Point{.rest = p, .at = *found, .place = surface.place(*found)});
    if (points_.size() > 1) {
      const Point& before = points_[points_.size() - 2];
      point.along = before.along + (point.place - before.place).norm();
    }
  }
  std::size_t from = 0, to = 0;
  for (Point& point : points_) {
    while (points_[from].along < point.along - direction_mm) ++from;
    while (to + 1 < points_.size() && points_[to].along < point.along + direction_mm) ++to;
    const Vector3d ahead = points_[to].place - points_[from].place,
                   left = surface.normal(point.at.triangle).cross(ahead);
    if (left.norm() > 0) point.left = left.normalized();
  }
}

std::optional<SheetPoint> PartLine::beside(const Point& point, double left_mm) const {
  if (left_mm == 0) return point.at;
  if (!(point.left.norm() > 0)) return std::nullopt;
  GeodesicWalk walk(surface_, point.at, left_mm > 0 ? point.left : Vector3d(-point.left));
  walk.advance(std::abs(left_mm));
  if (walk.ended()) return std::nullopt;
  return walk.at();
}

PartLine::Point PartLine::at(double along) const {
  const auto after = std::lower_bound(points_.begin(), points_.end(), along,
                                      [](const Point& p, double x) { return p.along < x; });
  if (after == points_.end()) return points_.back();
  if (after == points_.begin()) return points_.front();
  const Point &a = *(after - 1), &b = *after;
  const double share = (along - a.along) / (b.along - a.along);
  Point out = share < 0.5 ? a : b;
  const Vector2d rest = a.rest + share * (b.rest - a.rest);
  const auto found = locator_.find(rest);
  if (!found) return out;
  out.along = along;
  out.rest = rest;
  out.at = *found;
  out.place = surface_.place(*found);
  // In the plane of its own triangle.
  const Vector3d& normal = surface_.normal(found->triangle);
  const Vector3d left = out.left - out.left.dot(normal) * normal;
  if (left.norm() > 0) out.left = left.normalized();
  return out;
}

std::vector<PartLine::Point> PartLine::between(double from, double to) const {
  if (points_.size() < 2 || !(to > from)) return {};
  std::vector<Point> out{at(from)};
  for (const Point& p : points_)
    if (p.along > from + 1e-6 && p.along < to - 1e-6) out.push_back(p);
  out.push_back(at(to));
  return out;
}

std::vector<Vector2d> PartLine::beside_line(double from, double to, const Left& left) const {
  std::vector<Vector2d> out;
  for (const Point& p : between(from, to))
    if (const auto found = beside(p, left(p.along))) out.push_back(surface_.rest(*found));
  return out;
}

Area PartLine::strip(double from, double to, const Left& right_edge, const Left& left_edge) const {
  Ring ring = beside_line(from, to, right_edge), left = beside_line(from, to, left_edge);
  ring.insert(ring.end(), left.rbegin(), left.rend());
  if (ring.size() < 3) return {};
  Area out = union_of({ring});
  constexpr double least_mm2 = 0.02;  // where an edge folds over itself at a bend, slivers are left
  std::erase_if(out, [&](const Ring& each) { return std::abs(signed_area(each)) < least_mm2; });
  return out;
}

}  // namespace vacuform
