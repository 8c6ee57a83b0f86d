#include "worker/placement/alignment.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/numerics/rigid_fit.hpp"
#include "worker/surface/geodesic.hpp"
#include "worker/surface/nearest_point.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Pair {
  Vector2d drawn, chart;  // the point of the drawing at its scale, and its target
};

Result<std::vector<Pair>> pairs(const ChartedSurface& charted, const PatternSettings& settings) {
  constexpr double farthest_mm = 20;
  std::vector<Pair> out;
  for (std::size_t i = 0; i < settings.points.size(); ++i) {
    const auto& row = settings.points[i];
    const auto nearest = nearest_point(charted.surface().triangles(), charted.surface().inked(),
                                       charted.flattening().triangles, Vector3d(row[2], row[3], row[4]));
    if (nearest.distance_mm > farthest_mm)
      return fail(Code::bad_settings,
                  "a point of the mold lies " + decimal(nearest.distance_mm, 1) +
                      " mm off the part of the sheet that takes the drawing",
                  "pattern.points[" + std::to_string(i) + "]", "pick a point on the formed part");
    out.push_back({settings.scale * Vector2d(row[0], row[1]), charted.chart(nearest.point)});
  }
  return out;
}

// A point of the drawing, at its scale, and of the chart that lie on each other before the drawing is moved by its
// offset; and the turn of the drawing about them.
struct Pivot {
  Vector2d drawn{0, 0}, chart{0, 0};
  double turn_deg = 0;
};

Result<Pivot> pivot_of(const ChartedSurface& charted, const PatternSettings& settings) {
  if (settings.points.empty()) return Pivot{{0, 0}, {0, 0}, settings.rotate_deg};
  VACUFORM_TRY(met, pairs(charted, settings));
  RigidFit fit;
  for (const Pair& p : met) fit.add(p.drawn, p.chart);
  if (met.size() > 1 && fit.direction() < 1e-6)
    return fail(Code::bad_settings, "the points give the drawing no direction", "pattern.points",
                "pick points that lie apart, in the drawing and on the mold");
  const double turn = met.size() > 1 ? fit.angle() * 180 / M_PI : 0;
  // With two points the first is the pivot: it matches exactly.
  const bool first = met.size() == 2;
  return Pivot{first ? met[0].drawn : fit.from(), first ? met[0].chart : fit.to(),
               turn + settings.rotate_deg};
}

// A place on the chart, and the turn there of directions that come from the pivot along the surface, against the chart.
struct Moved {
  Vector2d chart;
  double turn_deg = 0;
  std::optional<Vector3d> place = {};  // mm
};

// Walks the geodesic that leaves `from` in the direction `by` of the chart there.
Result<Moved> move_along_surface(const ChartedSurface& charted, const Vector2d& from, const Vector2d& by) {
  if (by.isZero(0)) return Moved{.chart = from};
  const ChartedSurface::OnChart start = charted.at_chart(from);
  if (start.off_mm > 0) return Moved{.chart = from + by};  // pins put the origin where no surface is
  const InkedSurface& surface = charted.surface();
  const int t = start.point.triangle;
  const Vector3d axis = charted.axis(t), along = by.x() * axis + by.y() * surface.normal(t).cross(axis);
  const double back = angle_between(surface, t, along, axis), length = by.norm();
  GeodesicWalk walk(surface, start.point, along);
  const Vector2d begin = charted.chart(walk.at());  // a rounding beside `from` if that is on an edge
  constexpr double step_mm = 1;
  for (double walked = 0; walked < length; walked += step_mm) {
    walk.advance(std::min(step_mm, length - walked));
    if (walk.ended() || !charted.on_chart(walk.at().triangle))
      return fail(Code::bad_settings,
                  "the offset leads off the formed part after " + decimal(walked, 0) + " of " +
                      decimal(length, 0) + " mm",
                  "pattern.offset_mm", "give a smaller offset in that direction");
  }
  const int end = walk.at().triangle;
  const Vector3d there = turned(surface, end, walk.along(), back);
  return Moved{from + charted.chart(walk.at()) - begin,
               angle_between(surface, end, charted.axis(end), there) * 180 / M_PI, surface.place(walk.at())};
}

Vector2d offset_of(const PatternSettings& settings) { return {settings.offset_mm[0], settings.offset_mm[1]}; }

Alignment laid(const Pivot& pivot, const Moved& moved, double scale) {
  Alignment out{pivot.turn_deg + moved.turn_deg, scale, Vector2d::Zero(), moved.place};
  out.shift_mm = moved.chart - out.chart(pivot.drawn / scale);
  return out;
}

}  // namespace

Vector2d Alignment::pattern(const Vector2d& chart_mm) const {
  return Eigen::Rotation2Dd(-turn_deg * M_PI / 180) * (chart_mm - shift_mm) / scale;
}

Eigen::Affine2d Alignment::to_pattern() const {
  return Eigen::Scaling(1 / scale) * Eigen::Rotation2Dd(-turn_deg * M_PI / 180) *
         Eigen::Translation2d(-shift_mm);
}

Vector2d Alignment::chart(const Vector2d& pattern_mm) const {
  return Eigen::Rotation2Dd(turn_deg * M_PI / 180) * (scale * pattern_mm) + shift_mm;
}

Alignment plain_alignment(const PatternSettings& settings) {
  return {settings.rotate_deg, settings.scale, {settings.offset_mm[0], settings.offset_mm[1]}};
}

Result<Alignment> align(const ChartedSurface& charted, const PatternSettings& settings) {
  VACUFORM_TRY(pivot, pivot_of(charted, settings));
  VACUFORM_TRY(moved, move_along_surface(charted, pivot.chart, offset_of(settings)));
  return laid(pivot, moved, settings.scale);
}

Result<Alignment> align_flat(const ChartedSurface& charted, const PatternSettings& settings) {
  VACUFORM_TRY(pivot, pivot_of(charted, settings));
  return laid(pivot, {.chart = pivot.chart + offset_of(settings)}, settings.scale);
}

}  // namespace vacuform
