#include "worker/printing/ink_compensation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr int steps = 4;  // of the samples along a triangle's side

double stretched_area(const Patch& chart, const Triangle& t) {
  const auto at = [&](const auto& points, std::size_t k) { return points[t[k]]; };
  const Vector2d a = at(chart.rest, 1) - at(chart.rest, 0), b = at(chart.rest, 2) - at(chart.rest, 0);
  const double flat = std::abs(cross(a, b));
  const Eigen::Vector3d p = at(chart.inked, 1) - at(chart.inked, 0),
                        q = at(chart.inked, 2) - at(chart.inked, 0);
  const double formed = p.cross(q).norm();
  return flat > 0 && formed > 0 ? formed / flat : 1;
}

// Neither paper nor full ink, and the same all around: not the smoothed edge of something black.
bool is_shade(const Pattern& pattern, const Vector2d& uv, double coverage, double texel) {
  if (coverage < 0.05 || coverage > 0.95) return false;
  for (const Vector2d& d : {Vector2d(2, 0), Vector2d(-2, 0), Vector2d(0, 2), Vector2d(0, -2)})
    if (std::abs(static_cast<double>(pattern.sample(uv + texel * d, 0).coverage()) - coverage) > 0.15)
      return false;
  return true;
}

}  // namespace

std::vector<std::vector<double>> ink_gain(const std::vector<const Patch*>& patches, const Pattern& pattern) {
  if (!pattern.grayscale()) return {};
  const double texel = pattern.size_mm().x() / pattern.size_pixels().x();
  std::vector<std::vector<double>> gain;
  double most = 1;
  int inked = 0, shades = 0;
  for (const Patch* patch : patches) {
    gain.emplace_back();
    for (const Triangle& t : patch->triangles) {
      gain.back().push_back(stretched_area(*patch, t));
      const auto at = [&](std::size_t k) { return patch->uv[t[k]]; };
      const Vector2d a = at(0), b = at(1) - a, c = at(2) - a;
      for (int i = 0; i < steps; ++i)
        for (int j = 0; i + j < steps; ++j) {
          const Vector2d uv = a + b * (i + 1.0 / 3) / steps + c * (j + 1.0 / 3) / steps;
          const double coverage = pattern.sample(uv, 0).coverage();
          if (coverage < 0.05) continue;
          ++inked;
          if (is_shade(pattern, uv, coverage, texel)) ++shades;
          most = std::max(most, coverage * gain.back().back());
        }
    }
  }
  if (shades * 100 < inked || inked == 0) return {};
  for (auto& of_patch : gain)
    for (double& g : of_patch) g /= most;
  return gain;
}

}  // namespace vacuform
