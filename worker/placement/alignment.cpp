#include "worker/placement/alignment.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/numerics/rigid_fit.hpp"
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
  if (settings.points.empty()) return plain_alignment(settings);
  VACUFORM_TRY(met, pairs(charted, settings));
  RigidFit fit;
  for (const Pair& p : met) fit.add(p.drawn, p.chart);
  if (met.size() > 1 && fit.direction() < 1e-6)
    return fail(Code::bad_settings, "the points give the drawing no direction", "pattern.points",
                "pick points that lie apart, in the drawing and on the mold");
  const double turn = met.size() > 1 ? fit.angle() * 180 / M_PI : 0;
  // With two points the first is the pivot: it matches exactly.
  const bool pivot = met.size() == 2;
  const Vector2d drawn = pivot ? met[0].drawn : fit.from(), chart = pivot ? met[0].chart : fit.to();
  Alignment out{turn + settings.rotate_deg, settings.scale, Vector2d::Zero()};
  out.shift_mm = chart + plain_alignment(settings).shift_mm - out.chart(drawn / settings.scale);
  return out;
}

}  // namespace vacuform
