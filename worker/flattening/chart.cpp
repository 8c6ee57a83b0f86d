#include "worker/flattening/chart.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/numerics/plane.hpp"

namespace vacuform {

FlatTriangle flat_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const double length = ab.norm();
  if (length == 0) return {0, ac.norm(), 0};
  return {length, ac.dot(ab) / length, ab.cross(ac).norm() / length};
}

std::vector<ChartElement> elements(const Chart& chart) {
  constexpr double flattest = 1e-4, shortest_mm = 1e-6;
  std::vector<ChartElement> all;
  all.reserve(chart.triangles.size());
  for (const Triangle& t : chart.triangles) {
    FlatTriangle f = flat_triangle(chart.inked[t[0]], chart.inked[t[1]], chart.inked[t[2]]);
    f.length = std::max({f.length, flattest * std::abs(f.along), shortest_mm});
    f.height = std::max({f.height, flattest * f.length, flattest * std::abs(f.along)});
    // Inverse of the map (length, along; 0, height) that carries the unit triangle here.
    ChartElement e;
    e.gradient.row(1) << 1 / f.length, -f.along / (f.length * f.height);
    e.gradient.row(2) << 0, 1 / f.height;
    e.gradient.row(0) = -e.gradient.row(1) - e.gradient.row(2);
    e.area = 0.5 * f.length * f.height;
    all.push_back(e);
  }
  return all;
}

ChartQuality chart_quality(const Chart& chart) {
  ChartQuality quality;
  double total = 0;
  for (const Triangle& t : chart.triangles) {
    const FlatTriangle f = flat_triangle(chart.inked[t[0]], chart.inked[t[1]], chart.inked[t[2]]);
    const double area = 0.5 * f.length * f.height;
    const Eigen::Vector2d e1 = chart.uv[t[1]] - chart.uv[t[0]], e2 = chart.uv[t[2]] - chart.uv[t[0]];
    quality.flipped += cross(e1, e2) <= 0;
    if (!(area > 0)) continue;
    // J from the triangle's plane to the chart: J (length, 0) = e1, J (along, height) = e2.
    const Eigen::Vector2d j1 = e1 / f.length, j2 = (e2 - f.along * j1) / f.height;
    const double frobenius = j1.squaredNorm() + j2.squaredNorm();
    const double determinant = cross(j1, j2);
    const double sum = std::sqrt(std::max(0.0, frobenius + 2 * determinant));  // s1 + s2
    quality.arap += area * (frobenius - 2 * sum + 2);
    quality.symmetric_dirichlet += determinant > 0 ? area * frobenius * (1 + 1 / (determinant * determinant))
                                                   : std::numeric_limits<double>::infinity();
    total += area;
  }
  if (total > 0) quality.arap /= total, quality.symmetric_dirichlet /= total;
  return quality;
}

}  // namespace vacuform
