#include "worker/surface/inked_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Barycentric weights of p in the triangle a, b, c, or without area none that are finite.
Vector3d weights_of(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const auto cross = [](const Vector2d& x, const Vector2d& y) { return x.x() * y.y() - x.y() * y.x(); };
  return Vector3d(cross(b - p, c - p), cross(c - p, a - p), cross(a - p, b - p)) / cross(b - a, c - a);
}

// Fraction along a to b of the point nearest to p.
template <class V>
double nearest_on_edge(const V& p, const V& a, const V& b) {
  const double square = (b - a).squaredNorm();
  return square > 0 ? std::clamp((p - a).dot(b - a) / square, 0.0, 1.0) : 0;
}

// Weights of the point nearest to p of the triangle in space.
Vector3d nearest_weights(const Vector3d& p, const std::array<Vector3d, 3>& corner) {
  const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  if (const double square = normal.squaredNorm(); square > 0) {
    Vector3d w;
    for (int k = 0; k < 3; ++k) {
      const Vector3d &b = corner[static_cast<std::size_t>((k + 1) % 3)],
                     &c = corner[static_cast<std::size_t>((k + 2) % 3)];
      w[k] = (b - p).cross(c - p).dot(normal) / square;
    }
    if (w.minCoeff() >= 0) return w / w.sum();
  }
  Vector3d best = Vector3d::UnitX();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector3d &a = corner[static_cast<std::size_t>(k)],
                   &b = corner[static_cast<std::size_t>((k + 1) % 3)];
    const double f = nearest_on_edge(p, a, b), d = (a + f * (b - a) - p).squaredNorm();
    if (d >= least) continue;
    least = d;
    best.setZero();
    best[k] = 1 - f;
    best[(k + 1) % 3] = f;
  }
  return best;
}

}  // namespace

InkedSurface::InkedSurface(const FormedSheet& sheet, const Flattening& flattening)
    : sheet_(&sheet),
      flattening_(&flattening),
      on_chart_(sheet.triangles.size(), 0),
      path_mesh_(sheet.triangles, flattening.inked) {
  for (const int t : flattening.triangles) on_chart_[index(t)] = 1;
  faces_.reserve(sheet.triangles.size());
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = flattening.inked[index(sheet.triangles[t][k])];
    Face face{(p[1] - p[0]).cross(p[2] - p[0]), {}};
    const double square = face.normal.squaredNorm();
    for (std::size_t k = 0; k < 3; ++k)
      face.gradient[k] = square > 0 ? Vector3d(face.normal.cross(p[(k + 2) % 3] - p[(k + 1) % 3]) / square)
                                    : Vector3d(Vector3d::Zero());
    if (square > 0) face.normal /= std::sqrt(square);
    faces_.push_back(face);
  }
}

Vector3d InkedSurface::place(const SheetPoint& p) const {
  return interpolate(sheet_->triangles, p, flattening_->inked);
}

Vector2d InkedSurface::rest(const SheetPoint& p) const {
  return interpolate(sheet_->triangles, p, sheet_->rest);
}

Vector2d InkedSurface::chart(const SheetPoint& p) const {
  if (!on_chart(p.triangle)) return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return interpolate(sheet_->triangles, p, flattening_->chart);
}

InkedSurface::OnChart InkedSurface::at_chart(const Vector2d& chart) const {
  OnChart best;
  best.off_mm = std::numeric_limits<double>::infinity();
  for (const int t : flattening_->triangles) {
    const Triangle& corners = sheet_->triangles[index(t)];
    const Vector2d &a = flattening_->chart[index(corners[0])], &b = flattening_->chart[index(corners[1])],
                   &c = flattening_->chart[index(corners[2])];
    const Vector3d w = weights_of(chart, a, b, c);
    if (w.allFinite() && w.minCoeff() >= 0) return {{t, w}, 0};
    for (int k = 0; k < 3; ++k) {
      const int n = across(t, k);
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

InkedSurface::Nearest InkedSurface::nearest_on_chart(const Vector3d& place) const {
  Nearest best;
  best.distance_mm = std::numeric_limits<double>::infinity();
  for (const int t : flattening_->triangles) {
    const Triangle& corners = sheet_->triangles[index(t)];
    const std::array<Vector3d, 3> p{flattening_->inked[index(corners[0])],
                                    flattening_->inked[index(corners[1])],
                                    flattening_->inked[index(corners[2])]};
    const Vector3d w = nearest_weights(place, p);
    const double d = (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] - place).norm();
    if (d < best.distance_mm) best = {{t, w}, d};
  }
  return best;
}

Vector3d InkedSurface::chart_axis(int t) const {
  const Triangle& corners = sheet_->triangles[index(t)];
  const auto& flat = on_chart(t) ? flattening_->chart : sheet_->rest;
  // Rows of the map from the triangle's plane to the chart; the nearest rotation sends a + normal x b to u (twice it).
  Vector3d a = Vector3d::Zero(), b = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    a += flat[index(corners[index(k)])].x() * gradient(t, k);
    b += flat[index(corners[index(k)])].y() * gradient(t, k);
  }
  Vector3d axis = a - normal(t).cross(b);
  if (axis.squaredNorm() == 0) axis = normal(t).unitOrthogonal();
  return axis.normalized();
}

}  // namespace vacuform
