#include "worker/placement/polar_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/numerics/plane.hpp"
#include "worker/placement/element_patch.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double area(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return 0.5 * (b - a).cross(c - a).norm();
}

}  // namespace

PolarGrid::PolarGrid(const ChartedSurface& charted, const SheetPoint& centre, const Vector3d& axis,
                     double reach_mm, CoilKeep keep, int directions)
    : directions_(directions),
      rings_(std::max(2, static_cast<int>(std::ceil(reach_mm)))),
      spacing_(reach_mm / rings_),
      stops_(static_cast<std::size_t>((rings_ + 1) * directions)) {
  const InkedSurface& surface = charted.surface();
  for (int d = 0; d < directions; ++d) {
    const auto put = [&](int ring, const SheetPoint& p) {
      stops_[ring * directions + d] = {true, charted.on_chart(p.triangle), surface.rest(p), surface.place(p)};
    };
    put(0, centre);
    GeodesicWalk walk(surface, centre, turned(surface, centre.triangle, axis, 2 * M_PI * d / directions));
    for (int ring = 1; ring <= rings_; ++ring) {
      walk.advance(spacing_);
      if (walk.ended()) break;
      put(ring, walk.at());
    }
  }
  if (keep == CoilKeep::area)
    measure();
  else
    for (int ring = 0; ring <= rings_; ++ring) flat_.push_back(spacing_ * ring);
}

// The radii of the plane's circles.
void PolarGrid::measure() {
  const double step = 2 * M_PI / directions_, polygon = step / std::sin(step);
  double within = 0, share = 1;  // of the plane's area
  flat_.assign(1, 0);
  for (int ring = 0; ring < rings_; ++ring) {
    double here = 0;
    int there = 0;
    for (int d = 0; d < directions_; ++d) {
      const Stop &a = stop(ring, d), &b = stop(ring + 1, d), &c = stop(ring + 1, d + 1),
                 &e = stop(ring, d + 1);
      if (!b.there || !c.there) continue;
      ++there;
      here += area(a.inked, b.inked, c.inked) + (ring > 0 ? area(a.inked, c.inked, e.inked) : 0);
    }
    const double plane = M_PI * spacing_ * spacing_ * (2 * ring + 1);
    if (there > 0) share = here * polygon * directions_ / there / plane;
    within += share * plane;
    flat_.push_back(std::sqrt(within / M_PI));
  }
}

double PolarGrid::flat_radius(double geodesic_mm) const {
  const double r = std::max(0.0, geodesic_mm / spacing_);
  const int ring = std::min(static_cast<int>(r), rings_ - 1);
  const double a = flat_[ring], b = flat_[static_cast<std::size_t>(ring) + 1];
  return a + (r - ring) * (b - a);
}

double PolarGrid::geodesic_radius(double flat_mm) const {
  const auto above = std::upper_bound(flat_.begin() + 1, flat_.end() - 1, flat_mm);
  const double a = *(above - 1), b = *above;
  const double ring = static_cast<double>(above - flat_.begin() - 1);
  return spacing_ * (ring + (b > a ? (flat_mm - a) / (b - a) : 0));
}

std::optional<PolarGrid::Cell> PolarGrid::cell(const Vector2d& flat) const {
  const double step = 2 * M_PI / directions_;
  double angle = std::atan2(flat.y(), flat.x());
  if (angle < 0) angle += 2 * M_PI;
  const int direction = std::min(static_cast<int>(angle / step), directions_ - 1);
  // Within a sector the rings are chords: flat = p e(direction) + q e(direction + 1), on the chord of radius p + q.
  const Vector2d e(std::cos(direction * step), std::sin(direction * step)),
      f(std::cos((direction + 1) * step), std::sin((direction + 1) * step));
  const double p = cross(flat, f) / cross(e, f), q = cross(e, flat) / cross(e, f);
  const double radius = p + q;
  const auto above = std::upper_bound(flat_.begin() + 1, flat_.end() - 1, radius);
  const int ring = static_cast<int>(above - flat_.begin()) - 1;
  const double a = *(above - 1), b = *above;
  if (radius > b || !stop(ring + 1, direction).there || !stop(ring + 1, direction + 1).there) return {};
  return Cell{ring, direction, b > a ? (radius - a) / (b - a) : 0, radius > 0 ? q / radius : 0};
}

std::optional<Vector3d> PolarGrid::place(const Vector2d& flat) const {
  const auto c = cell(flat);
  if (!c) return {};
  const auto chord = [&](int ring) -> Vector3d {
    return (1 - c->onward) * stop(ring, c->direction).inked + c->onward * stop(ring, c->direction + 1).inked;
  };
  return (1 - c->outward) * chord(c->ring) + c->outward * chord(c->ring + 1);
}

bool PolarGrid::on_chart(const Vector2d& flat) const {
  const auto c = cell(flat);
  if (!c) return false;
  for (const int ring : {c->ring, c->ring + 1})
    for (const int direction : {c->direction, c->direction + 1})
      if (!stop(ring, direction).on_chart) return false;
  return true;
}

bool PolarGrid::folded(double flat_mm) const {
  for (int ring = 0; ring < rings_ && flat_[ring] < flat_mm; ++ring)
    for (int d = 0; d < directions_; ++d) {
      const Stop &a = stop(ring, d), &b = stop(ring + 1, d), &c = stop(ring + 1, d + 1),
                 &e = stop(ring, d + 1);
      if (!b.there || !c.there) continue;
      if (cross(b.rest - a.rest, c.rest - a.rest) <= 0) return true;
      if (ring > 0 && cross(c.rest - a.rest, e.rest - a.rest) <= 0) return true;
    }
  return false;
}

ElementPatch PolarGrid::patch() const {
  ElementPatch whole;
  Patch& out = whole.patch;
  const double step = 2 * M_PI / directions_;
  std::vector<int> vertex(stops_.size(), -1);
  for (int ring = 0; ring <= rings_; ++ring)
    for (int d = 0; d < (ring > 0 ? directions_ : 1); ++d) {
      const Stop& s = stop(ring, d);
      if (!s.there) continue;
      vertex[ring * directions_ + d] = static_cast<int>(out.uv.size());
      out.uv.push_back(flat_[ring] * Vector2d(std::cos(d * step), std::sin(d * step)));
      out.rest.push_back(s.rest);
      out.inked.push_back(s.inked);
    }
  const auto at = [&](int ring, int d) {
    return vertex[ring * directions_ + (ring > 0 ? d % directions_ : 0)];
  };
  for (int ring = 0; ring < rings_; ++ring)
    for (int d = 0; d < directions_; ++d) {
      const int a = at(ring, d), b = at(ring + 1, d), c = at(ring + 1, d + 1), e = at(ring, d + 1);
      if (b < 0 || c < 0) continue;
      const auto on = [&](int r, int direction) { return stop(r, direction).on_chart; };
      const bool first = on(ring, d) && on(ring + 1, d) && on(ring + 1, d + 1);
      out.triangles.push_back({a, b, c});
      whole.on_chart.push_back(first);
      if (ring == 0) continue;
      out.triangles.push_back({a, c, e});
      whole.on_chart.push_back(on(ring, d) && on(ring + 1, d + 1) && on(ring, d + 1));
    }
  return whole;
}

std::vector<PolarGrid::Passing> PolarGrid::passing() const {
  std::vector<Passing> out;
  for (int ring = 1; ring <= rings_; ++ring)
    for (int d = 0; d < directions_; ++d)
      if (stop(ring, d).there) out.push_back({2 * M_PI * d / directions_, stop(ring, d).rest});
  return out;
}

}  // namespace vacuform
