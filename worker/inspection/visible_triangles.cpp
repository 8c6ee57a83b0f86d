#include "worker/inspection/visible_triangles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vacuform {

namespace {

using Eigen::Vector3d;
constexpr double near_mm = 1e-3;   // a corner that is nearer to the eye is not projected
constexpr double rounding = 1e-6;  // samples
constexpr double most_samples = 1e6;
constexpr double slack =
    1e-14;  // of the square of a corner's distance: rounding in the three functions of a triangle

// The samples whose middles lie in [from, to].
int first_sample(double from) {
  return static_cast<int>(std::ceil(std::clamp(from, -most_samples, most_samples) - rounding - 0.5));
}
int last_sample(double to) {
  return static_cast<int>(std::floor(std::clamp(to, -most_samples, most_samples) + rounding - 0.5));
}

// A function that is linear in the picture. For two triangles that share an edge, the function of one is exactly the
// negative of that of the other.
struct Linear {
  double x, y, constant;
  Linear(const Vector3d& a, const Vector3d& b, const Camera& camera) {
    const Vector3d normal = a.cross(b);
    x = camera.pixel * normal.dot(camera.right);
    y = camera.pixel * normal.dot(camera.up);
    constant = -normal.dot(camera.back);
  }
};

}  // namespace

VisibleTriangles::VisibleTriangles(const TriangleMesh& mesh, const Camera& camera, int width)
    : mesh_(mesh), camera_(camera), columns_(2 * width) {
  corners_.reserve(mesh.vertices.size());
  seen_.reserve(mesh.vertices.size());
  for (const Vector3d& vertex : mesh.vertices) {
    const Vector3d p = vertex - camera.eye;
    const double depth = -p.dot(camera.back), scale = depth * camera.pixel;
    corners_.push_back(p);
    seen_.emplace_back(2 * (camera.middle_x + p.dot(camera.right) / scale),
                       2 * (camera.middle_y - p.dot(camera.up) / scale), depth);
  }
  rows_.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    double low = std::numeric_limits<double>::infinity(), high = -low, left = low, right = high;
    double shallowest = low, deepest = high;
    for (const int v : t) {
      const Vector3d& p = seen_[v];
      left = std::min(left, p.x()), right = std::max(right, p.x());
      low = std::min(low, p.y()), high = std::max(high, p.y());
      shallowest = std::min(shallowest, p.z()), deepest = std::max(deepest, p.z());
    }
    const bool projected = shallowest > near_mm;
    const bool beside = projected && (last_sample(right) < 0 || first_sample(left) >= columns_);
    if (!(deepest > 0) || beside)
      rows_.push_back({0, -1});
    else if (!projected)
      rows_.push_back({0, std::numeric_limits<int>::max()});
    else
      rows_.push_back({first_sample(low), last_sample(high)});
  }
}

void VisibleTriangles::see(int top, int bottom, std::vector<Sample>& samples) const {
  const int begin = 2 * top, end = 2 * bottom;
  samples.assign(static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(columns_), {});
  for (std::size_t t = 0; t < rows_.size(); ++t) {
    const int first_row = std::max(begin, rows_[t].first), last_row = std::min(end - 1, rows_[t].last);
    if (first_row > last_row) continue;
    std::array<Vector3d, 3> p;
    int left = 0, right = columns_ - 1;
    double from = std::numeric_limits<double>::infinity(), to = -from, shallowest = from, farthest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh_.triangles[t][k]);
      p[k] = corners_[v];
      from = std::min(from, seen_[v].x()), to = std::max(to, seen_[v].x());
      shallowest = std::min(shallowest, seen_[v].z());
      farthest = std::max(farthest, p[k].squaredNorm());
    }
    const double least = -slack * farthest;
    if (shallowest > near_mm)
      left = std::max(left, first_sample(from)), right = std::min(right, last_sample(to));
    const Linear a(p[1], p[2], camera_), b(p[2], p[0], camera_), c(p[0], p[1], camera_);
    const double volume = p[0].dot(p[1].cross(p[2]));
    if (!(std::abs(volume) > 0)) continue;
    const double sign = volume > 0 ? 1 : -1, per_volume = 1 / std::abs(volume);
    for (int row = first_row; row <= last_row; ++row) {
      const double y = camera_.middle_y - (row + 0.5) / 2;
      const double in_a = y * a.y + a.constant, in_b = y * b.y + b.constant, in_c = y * c.y + c.constant;
      Sample* const line =
          &samples[static_cast<std::size_t>(row - begin) * static_cast<std::size_t>(columns_)];
      for (int column = left; column <= right; ++column) {
        const double x = (column + 0.5) / 2 - camera_.middle_x;
        const double of_a = sign * (x * a.x + in_a), of_b = sign * (x * b.x + in_b),
                     of_c = sign * (x * c.x + in_c);
        if (of_a < least || of_b < least || of_c < least) continue;
        const double sum = of_a + of_b + of_c, nearness = sum * per_volume;
        Sample& sample = line[column];
        if (!(nearness > sample.nearness)) continue;
        sample = {nearness, static_cast<float>(of_b / sum), static_cast<float>(of_c / sum),
                  static_cast<int>(t)};
      }
    }
  }
}

}  // namespace vacuform
