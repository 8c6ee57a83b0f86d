#include "worker/scan/symmetry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/scan/scan_file.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

constexpr int mirrored_points = 120, tried_directions = 200, tried_angles = 18;
constexpr std::size_t tried_starts = 6;
constexpr double crowded = 60;  // a distance then takes long
constexpr int few_points = 30;
constexpr double mirror_radian = std::numbers::pi / 180;

}  // namespace

MirrorTest::MirrorTest(const TriangleMesh& body) : distance_(body), size_(bounds(body).size().norm()) {
  double total = 0;
  const auto middle = [&](const Triangle& t) -> Eigen::Vector3d {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int v : t) sum += body.vertices[v];
    return sum / 3;
  };
  for (const auto& t : body.triangles) {
    const double area = area_vector(body, t).norm();
    centroid_ += area * middle(t);
    total += area;
  }
  centroid_ /= total;
  const int wanted = crowding_of(body) > crowded ? few_points : mirrored_points;
  double passed = 0;
  for (const auto& t : body.triangles) {
    passed += area_vector(body, t).norm();
    if (passed * wanted > total * (static_cast<double>(points_.size()) + 0.5))
      points_.push_back(middle(t) - centroid_);
  }
}

double MirrorTest::error(const Eigen::Vector3d& normal, std::size_t stride) const {
  double sum = 0, count = 0;
  int near = -1;
  for (std::size_t i = 0; i < points_.size(); i += stride, ++count)
    sum += distance_(centroid_ + points_[i] - 2 * normal.dot(points_[i]) * normal, near);
  return sum / (count * size_);
}

Result<MirrorTest::Plane> MirrorTest::refined(Plane plane, const ScanProgress& progress) const {
  plane.error = error(plane.normal);
  for (double step = 6 * mirror_radian; step > 0.4 * mirror_radian;) {
    VACUFORM_CHECK(progress.tick());
    const Plane before = plane;
    const Eigen::Vector3d a = before.normal.unitOrthogonal(), b = before.normal.cross(a);
    for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const Eigen::Vector3d normal = (before.normal + step * (x * a + y * b)).normalized();
      if (const double e = error(normal); e < plane.error) plane = {normal, e};
    }
    if (plane.error == before.error) step /= 2;
  }
  return plane;
}

Result<MirrorTest::Plane> MirrorTest::best(const ScanProgress& progress) const {
  std::vector<Plane> planes;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < tried_directions; ++i) {  // on half a sphere
    const double z = (i + 0.5) / tried_directions, r = std::sqrt(1 - z * z);
    const Eigen::Vector3d normal(r * std::cos(golden * i), r * std::sin(golden * i), z);
    VACUFORM_CHECK(progress.tick());
    planes.push_back({normal, error(normal, 3)});
  }
  std::stable_sort(planes.begin(), planes.end(),
                   [](const Plane& a, const Plane& b) { return a.error < b.error; });
  std::vector<Plane> starts;
  for (const Plane& plane : planes)
    if (starts.size() < tried_starts && std::ranges::none_of(starts, [&](const Plane& s) {
          return std::abs(s.normal.dot(plane.normal)) > 0.9;
        }))
      starts.push_back(plane);
  Plane best{Eigen::Vector3d::UnitX(), HUGE_VAL};
  for (const Plane& start : starts) {
    VACUFORM_TRY(plane, refined(start, progress));
    if (plane.error < best.error) best = plane;
  }
  return best;
}

Result<MirrorTest::Plane> MirrorTest::best_along(const Eigen::Vector3d& direction,
                                                 const ScanProgress& progress) const {
  const Eigen::Vector3d a = direction.unitOrthogonal(), b = direction.cross(a);
  Plane best{a, HUGE_VAL};
  double at = 0;
  const auto offer = [&](double angle) {
    const Eigen::Vector3d normal = std::cos(angle) * a + std::sin(angle) * b;
    if (const double e = error(normal); e < best.error) best = {normal, e}, at = angle;
  };
  for (int i = 0; i < tried_angles; ++i) {
    VACUFORM_CHECK(progress.tick());
    offer(std::numbers::pi * i / tried_angles);
  }
  for (double step = 4 * mirror_radian; step > mirror_radian / 2; step /= 2) {
    const double middle = at;
    offer(middle - step);
    offer(middle + step);
  }
  return best;
}

}  // namespace vacuform
