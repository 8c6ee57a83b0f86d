#include "worker/conductors/trace.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vacuform {

using Eigen::Vector2d;
using Eigen::Vector3d;

Trace::Trace(const DrawnLoop& loop, const Patch& patch, double width_mm, double scale)
    : path_(loop), patch_(patch), locator_(patch.triangles, patch.uv), width_mm_(width_mm), scale_(scale) {}

std::optional<SheetPoint> Trace::find(double along, double left_mm) const {
  Vector2d uv = path_.at(along);
  if (left_mm != 0) {
    constexpr double step = 0.05;
    const Vector2d ahead = (path_.at(along + step) - path_.at(along - step)).normalized();
    uv += left_mm / scale_ * Vector2d(-ahead.y(), ahead.x());
  }
  return locator_.nearest(uv, 1e-3);
}

std::optional<Vector3d> Trace::at(double along, double left_mm) const {
  const auto found = find(along, left_mm);
  if (!found) return std::nullopt;
  return interpolate(patch_.triangles, *found, patch_.inked);
}

std::optional<Vector2d> Trace::rest(double along, double left_mm) const {
  const auto found = find(along, left_mm);
  if (!found) return std::nullopt;
  return interpolate(patch_.triangles, *found, patch_.rest);
}

double Trace::clear_of(double along, const Trace& other, double along_other, double beyond_mm) const {
  constexpr double step_mm = 0.05, point_mm = 0.1;
  // The other trace as far as it may come near: traces that cross at 15 degrees are near for four widths.
  const double near_mm = 4 * (width_mm_ + other.width_mm_ + 2 * beyond_mm);
  std::vector<Vector3d> middle;
  for (double x = -near_mm; x <= near_mm; x += point_mm)
    if (const auto p = other.at(along_other + x / other.scale_)) middle.push_back(*p);
  const double least = other.width_mm_ / 2 + beyond_mm;
  const auto is_clear = [&](double at) {
    for (const double left : {-width_mm_ / 2, 0.0, width_mm_ / 2})
      if (const auto p = this->at(at, left))
        for (const Vector3d& q : middle)
          if ((*p - q).squaredNorm() < least * least) return false;
    return true;
  };
  const double most_mm = std::min(near_mm, path_.length() * scale_ / 4);
  double far = 0;
  for (const double side : {-1.0, 1.0}) {
    double mm = most_mm;  // from the outside, since a trace may come near again
    while (mm > 0 && is_clear(along + side * mm / scale_)) mm -= step_mm;
    far = std::max(far, mm + step_mm);
  }
  return far / scale_;
}

}  // namespace vacuform
