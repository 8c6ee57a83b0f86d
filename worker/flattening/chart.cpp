#include "worker/flattening/chart.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace vacuform {

FlatTriangle flat_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const double length = ab.norm();
  if (length == 0) return {0, ac.norm(), 0};
  return {length, ac.dot(ab) / length, ab.cross(ac).norm() / length};
}

ChartQuality chart_quality(const Chart& chart) {
  ChartQuality quality;
  double total = 0;
  for (const Triangle& t : chart.triangles) {
    const FlatTriangle f = flat_triangle(chart.inked[t[0]], chart.inked[t[1]], chart.inked[t[2]]);
    const double area = 0.5 * f.length * f.height;
    if (!(area > 0)) continue;
    // J from the triangle's plane to the chart: J (length, 0) = e1, J (along, height) = e2.
    const Eigen::Vector2d e1 = chart.uv[t[1]] - chart.uv[t[0]], e2 = chart.uv[t[2]] - chart.uv[t[0]];
    const Eigen::Vector2d j1 = e1 / f.length, j2 = (e2 - f.along * j1) / f.height;
    const double frobenius = j1.squaredNorm() + j2.squaredNorm();
    const double determinant = j1.x() * j2.y() - j1.y() * j2.x();
    const double sum = std::sqrt(std::max(0.0, frobenius + 2 * std::abs(determinant)));  // s1 + s2
    quality.energy += area * (frobenius - 2 * sum + 2);
    quality.flipped += determinant <= 0;
    total += area;
  }
  if (total > 0) quality.energy /= total;
  return quality;
}

}  // namespace vacuform
