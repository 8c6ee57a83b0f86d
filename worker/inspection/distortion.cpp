#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/inspection/inspection.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

double round_step(double least) {
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 2.5, 5.0})
    if (factor * decade >= least * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

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

Bins even_bins(double low, double high) {
  constexpr int wanted = 30;
  Bins bins{low, 0.01, 1};
  high = std::max(high, low + 0.02);
  bins.step = round_step((high - low) / wanted);
  bins.count = std::max(1, static_cast<int>(std::ceil((high - low) / bins.step - 1e-9)));
  return bins;
}

std::vector<double> shares(const std::vector<Weighted>& values, const Bins& bins) {
  std::vector<double> sums(static_cast<std::size_t>(bins.count), 0);
  double area = 0;
  for (const Weighted& w : values) {
    const double bin = std::floor((w.value - bins.low) / bins.step);
    sums[std::clamp(bin, 0.0, bins.count - 1.0)] += w.area;
    area += w.area;
  }
  for (double& sum : sums) sum /= area > 0 ? area : 1;
  return sums;
}

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

namespace {

void add(const std::array<Eigen::Vector2d, 3>& from, const std::array<Eigen::Vector3d, 3>& to,
         DistortionValues& out) {
  const double area = (to[1] - to[0]).cross(to[2] - to[0]).norm() / 2;
  const SingularValues s = singular_values(from, to);
  const double ratio = s.largest * s.smallest;
  // A triangle without area on either side has no figure and no weight.
  if (!(area > 0) || !(ratio > 0) || !std::isfinite(ratio)) return;
  out.shape.push_back({s.largest / s.smallest, area});
  out.area.push_back({std::max(ratio, 1 / ratio), area});
}

}  // namespace

CornersUv corners_of(const FormedSheet& sheet, const Flattening& flattening,
                     const std::vector<Eigen::Vector2d>& uv) {
  CornersUv out;
  for (const int t : flattening.triangles) {
    const Triangle& c = sheet.triangles[t];
    const auto at = [&](std::size_t k) { return uv[c[k]]; };
    out.push_back({at(0), at(1), at(2)});
  }
  return out;
}

CornersUv corners_of(const Print& print, const Alignment& alignment) {
  CornersUv out = print.pattern_uv;
  for (auto& corners : out)
    for (Eigen::Vector2d& uv : corners) uv *= alignment.scale;
  return out;
}

DistortionValues distortion_values(const InkedSurface& surface, const std::vector<int>& chart,
                                   const CornersUv& uv) {
  DistortionValues out;
  for (std::size_t i = 0; i < chart.size(); ++i) {
    const Triangle& c = surface.triangles()[chart[i]];
    const auto at = [&](std::size_t k) { return surface.inked()[c[k]]; };
    add(uv[i], {at(0), at(1), at(2)}, out);
  }
  return out;
}

Distortion distortion(DistortionValues values) {
  Distortion out;
  together([&] { out.shape = statistics(std::move(values.shape)); },
           [&] { out.area = statistics(std::move(values.area)); });
  return out;
}

Distortion distortion(const std::vector<const Patch*>& patches,
                      const std::function<Eigen::Vector2d(const Patch&, std::size_t)>& of) {
  DistortionValues values;
  for (const Patch* patch : patches)
    for (const Triangle& t : patch->triangles) {
      const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
                 c = static_cast<std::size_t>(t[2]);
      add({of(*patch, a), of(*patch, b), of(*patch, c)}, {patch->inked[a], patch->inked[b], patch->inked[c]},
          values);
    }
  return distortion(std::move(values));
}

}  // namespace vacuform
