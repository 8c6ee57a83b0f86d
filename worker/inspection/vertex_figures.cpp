#include "worker/inspection/vertex_figures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vacuform {

namespace {

using Eigen::Vector2d;

template <class Figure>
std::vector<double> over_vertices(const Finished& job, Figure&& figure) {
  std::vector<double> sum(job.sheet.formed.size(), 0), weight(sum.size(), 0);
  for (const int t : job.flattening.triangles) {
    std::array<Vector2d, 3> from;
    std::array<Eigen::Vector3d, 3> to;
    const auto& corners = job.sheet.triangles[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] = job.sheet.rest[static_cast<std::size_t>(corners[k])];
      to[k] = job.surface.inked()[static_cast<std::size_t>(corners[k])];
    }
    const double area = (to[1] - to[0]).cross(to[2] - to[0]).norm() / 2;
    const double value = figure(singular_values(from, to));
    if (!std::isfinite(value)) continue;
    for (const int v : corners)
      sum[static_cast<std::size_t>(v)] += area * value, weight[static_cast<std::size_t>(v)] += area;
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = weight[i] > 0 ? sum[i] / weight[i] : NAN;
  return sum;
}

}  // namespace

std::vector<double> anisotropy_of_vertices(const Finished& job) {
  return over_vertices(job, [](SingularValues s) { return s.largest / s.smallest; });
}

std::vector<double> area_ratio_of_vertices(const Finished& job) {
  return over_vertices(job, [](SingularValues s) {
    const double a = s.largest * s.smallest;
    return std::max(a, 1 / a);
  });
}

}  // namespace vacuform
