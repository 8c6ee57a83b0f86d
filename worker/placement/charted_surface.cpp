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
    : surface_(&surface), flattening_(&flattening), on_chart_(surface.triangles().size(), 0) {
  for (const int t : flattening.triangles) on_chart_[index(t)] = 1;
}

Vector2d ChartedSurface::chart(const SheetPoint& p) const {
  if (!on_chart(p.triangle)) return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return interpolate(surface_->triangles(), p, flattening_->chart);
}

ChartedSurface::OnChart ChartedSurface::at_chart(const Vector2d& chart) const {
  OnChart best;
  best.off_mm = std::numeric_limits<double>::infinity();
  for (const int t : flattening_->triangles) {
    const Triangle& corners = surface_->triangles()[index(t)];
    const Vector2d &a = flattening_->chart[index(corners[0])], &b = flattening_->chart[index(corners[1])],
                   &c = flattening_->chart[index(corners[2])];
    const Vector3d w = weights_of(chart, a, b, c);
    if (w.allFinite() && w.minCoeff() >= 0) return {{t, w}, 0};
    for (int k = 0; k < 3; ++k) {
      const int n = surface_->across(t, k);
      if (n >= 0 && on_chart(n)) continue;  // only the chart's border is of interest
      const int from = (k + 1) % 3, to = (k + 2) % 3;
      const Vector2d &p = flattening_->chart[index(corners[index(from)])],
                     &q = flattening_->chart[index(corners[index(to)])];
      const double f = nearest_on_edge(chart, p, q), d = (p + f * (q - p) - chart).norm();
      if (d >= best.off_mm) continue;
      best = {{t, Vector3d::Zero()}, d};
      best.point.weights[from] = 1 - f;
      best.point.weights[to] = f;
    }
  }
  return best;
}

Vector3d ChartedSurface::axis(int t) const {
  return surface_->axis(t, on_chart(t) ? flattening_->chart : surface_->rest());
}

}  // namespace vacuform
