#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/inspection/inspection.hpp"

namespace vacuform {
namespace {

struct Weighted {
  double value, area;
};

// Percentiles by area: the smallest value such that at least this share of the area has no larger one.
Statistics statistics(std::vector<Weighted> values) {
  Statistics result;
  if (values.empty()) return result;
  std::stable_sort(values.begin(), values.end(),
                   [](const Weighted& a, const Weighted& b) { return a.value < b.value; });
  double area = 0, sum = 0;
  for (const auto& w : values) area += w.area, sum += w.area * w.value;
  const auto percentile = [&](double share) {
    double below = 0;
    for (const auto& w : values)
      if ((below += w.area) >= share * area) return w.value;
    return values.back().value;
  };
  result.mean = sum / area;
  result.p95 = percentile(0.95);
  result.p99 = percentile(0.99);
  result.max = values.back().value;
  return result;
}

}  // namespace

SingularValues singular_values(const std::array<Eigen::Vector2d, 3>& from,
                               const std::array<Eigen::Vector3d, 3>& to) {
  Eigen::Matrix2d plane;
  plane << from[1] - from[0], from[2] - from[0];
  Eigen::Matrix<double, 3, 2> space;
  space << to[1] - to[0], to[2] - to[0];
  const Eigen::Matrix<double, 3, 2> J = space * plane.inverse();
  // In closed form from J^T J = [E F; F G]: (s1 + s2)^2 = E + G + 2 s1 s2 and s1^2 - s2^2 = sqrt((E - G)^2 +
  // 4 F^2), so that equal values come out equal and small ones are not lost in a difference.
  const double E = J.col(0).squaredNorm(), G = J.col(1).squaredNorm(), F = J.col(0).dot(J.col(1));
  const double product = Eigen::Vector3d(J.col(0)).cross(Eigen::Vector3d(J.col(1))).norm();
  const double sum = std::sqrt(E + G + 2 * product);
  const double difference = sum > 0 ? std::hypot(E - G, 2 * F) / sum : 0;
  const double largest = (sum + difference) / 2;
  return {largest, largest > 0 ? product / largest : 0};
}

Distortion distortion(const FormedSheet& sheet, const Flattening& flattening,
                      const std::vector<Eigen::Vector2d>& uv) {
  std::vector<Weighted> anisotropy, area_ratio;
  for (const int t : flattening.triangles) {
    std::array<Eigen::Vector2d, 3> from;
    std::array<Eigen::Vector3d, 3> to;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(sheet.triangles[static_cast<std::size_t>(t)][k]);
      from[k] = uv[v];
      to[k] = flattening.inked[v];
    }
    const double area = (to[1] - to[0]).cross(to[2] - to[0]).norm() / 2;
    const SingularValues s = singular_values(from, to);
    const double ratio = s.largest * s.smallest;
    // A triangle without area on either side has no figure and no weight.
    if (!(area > 0) || !(ratio > 0) || !std::isfinite(ratio)) continue;
    anisotropy.push_back({s.largest / s.smallest, area});
    area_ratio.push_back({std::max(ratio, 1 / ratio), area});
  }
  return {statistics(std::move(anisotropy)), statistics(std::move(area_ratio))};
}

}  // namespace vacuform
