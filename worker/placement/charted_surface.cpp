#include "worker/placement/charted_surface.hpp"

#include <limits>

#include "worker/numerics/plane.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/nearest_point.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Barycentric weights of p in the triangle a, b, c; not finite if it has no area.
Vector3d weights_of(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return Vector3d(cross(b - p, c - p), cross(c - p, a - p), cross(a - p, b - p)) / cross(b - a, c - a);
}

}  // namespace

ChartedSurface::ChartedSurface(const InkedSurface& surface, const Flattening& flattening)
    : surface_(&surface),
      flattening_(&flattening),
      on_chart_(surface.triangles().size(), 0),
      locator_(surface.triangles(), flattening.chart, flattening.triangles) {
  for (const int t : flattening.triangles) on_chart_[index(t)] = 1;
  for (const int t : flattening.triangles)
    for (int k = 0; k < 3; ++k)
      if (const int n = surface.across(t, k); n < 0 || !on_chart(n)) border_.emplace_back(t, k);
}

std::vector<Vector3d> ChartedSurface::border() const {
  std::vector<Vector3d> out;
  for (const auto& [t, k] : border_) {
    const Triangle& c = surface_->triangles()[index(t)];
    out.push_back(0.5 * (surface_->inked()[index(c[index((k + 1) % 3)])] +
                         surface_->inked()[index(c[index((k + 2) % 3)])]));
  }
  return out;
}

Vector2d ChartedSurface::chart(const SheetPoint& p) const {
  if (!on_chart(p.triangle)) return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return interpolate(surface_->triangles(), p, flattening_->chart);
}

ChartedSurface::OnChart ChartedSurface::at_chart(const Vector2d& chart,
                                                 const std::optional<Vector3d>& near) const {
  if (const auto on = near ? nearest_of(chart, *near) : locator_.find(chart)) {
    const Vector3d weights = on->weights.cwiseMax(0);
    return {{on->triangle, weights / weights.sum()}, 0};
  }
  OnChart best;
  best.off_mm = std::numeric_limits<double>::infinity();
  for (const auto& [t, k] : border_) {
    const Triangle& corners = surface_->triangles()[index(t)];
    const int from = (k + 1) % 3, to = (k + 2) % 3;
    const Vector2d &p = flattening_->chart[index(corners[index(from)])],
                   &q = flattening_->chart[index(corners[index(to)])];
    const double f = nearest_on_edge(chart, p, q), d = (p + f * (q - p) - chart).norm();
    if (d >= best.off_mm) continue;
    best = {{t, Vector3d::Zero()}, d};
    best.point.weights[from] = 1 - f;
    best.point.weights[to] = f;
  }
  return best;
}

std::optional<SheetPoint> ChartedSurface::nearest_of(const Vector2d& chart, const Vector3d& near) const {
  std::optional<SheetPoint> best;
  double nearest = std::numeric_limits<double>::infinity();
  for (const int t : flattening_->triangles) {
    const Triangle& c = surface_->triangles()[index(t)];
    const Vector3d w = weights_of(chart, flattening_->chart[index(c[0])], flattening_->chart[index(c[1])],
                                  flattening_->chart[index(c[2])]);
    // Rounding must not let a point on an edge fall between its two triangles.
    constexpr double rounding = 1e-9;
    if (!w.allFinite() || w.minCoeff() < -rounding) continue;
    const double mm = (surface_->place({t, w}) - near).norm();
    if (mm < nearest) nearest = mm, best = SheetPoint{t, w};
  }
  return best;
}

Vector3d ChartedSurface::axis(int t) const {
  return surface_->axis(t, on_chart(t) ? flattening_->chart : surface_->rest());
}

}  // namespace vacuform
