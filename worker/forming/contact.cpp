#include "worker/forming/contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vacuform {

namespace {
// A ray starts this much early, mm: a point that touches the mold within rounding must still hit it.
constexpr double back_off = 0.02;
}  // namespace

Obstacles::Obstacles(const TriangleMesh& mold, const MachineSettings& machine)
    : mold_(mold), rays_(mold), distance_(mold, rays_), machine_(machine) {
  if (mold.vertices.empty()) return;
  Eigen::Array2d high = low_ = mold.vertices.front().head<2>().array();
  for (const Eigen::Vector3d& p : mold.vertices) {
    low_ = low_.min(p.head<2>().array());
    high = high.max(p.head<2>().array());
  }
  constexpr double most_cells = 1000;  // a side; no mold fits a machine that is larger
  columns_ = static_cast<int>(std::min(most_cells, (high.x() - low_.x()) / cell_mm)) + 1;
  rows_ = static_cast<int>(std::min(most_cells, (high.y() - low_.y()) / cell_mm)) + 1;
  highest_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -HUGE_VAL);
  for (const Triangle& t : mold.triangles) {
    const Eigen::Vector3d &a = mold.vertices[t[0]], &b = mold.vertices[t[1]], &c = mold.vertices[t[2]];
    const auto [x0, x1, y0, y1] = cells(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
    const double top = std::max({a.z(), b.z(), c.z()});
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        double& highest = highest_[y * columns_ + x];
        highest = std::max(highest, top);
      }
  }
}

std::array<int, 4> Obstacles::cells(const Eigen::Vector3d& low, const Eigen::Vector3d& high) const {
  const auto cell = [](double offset, int count) {
    return static_cast<int>(std::clamp(offset / cell_mm, 0.0, count - 1.0));
  };
  return {cell(low.x() - low_.x(), columns_), cell(high.x() - low_.x(), columns_),
          cell(low.y() - low_.y(), rows_), cell(high.y() - low_.y(), rows_)};
}

bool Obstacles::misses_mold(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  if (highest_.empty()) return true;
  const Eigen::Vector3d low = from.cwiseMin(to).array() - back_off,
                        high = from.cwiseMax(to).array() + back_off;
  const auto [x0, x1, y0, y1] = cells(low, high);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x)
      if (highest_[y * columns_ + x] >= low.z()) return false;
  return true;
}

std::optional<double> Obstacles::leaves_window(const Eigen::Vector3d& from,
                                               const Eigen::Vector3d& way) const {
  double t = 2;
  if (machine_.window == WindowShape::circle) {
    // |from + t way| = radius in the plane: the larger root, as `from` lies inside.
    const Eigen::Vector2d o = from.head<2>(), d = way.head<2>();
    const double radius = machine_.window_width_mm / 2, a = d.squaredNorm();
    if (a > 0) {
      const double b = o.dot(d), c = std::min(0.0, o.squaredNorm() - radius * radius);
      t = (std::sqrt(b * b - a * c) - b) / a;
    }
  } else {
    const double half[2] = {machine_.window_width_mm / 2, machine_.window_height_mm / 2};
    for (int k = 0; k < 2; ++k)
      if (way[k] != 0) t = std::min(t, std::max(0.0, (std::copysign(half[k], way[k]) - from[k]) / way[k]));
  }
  return t <= 1 ? std::optional(t) : std::nullopt;
}

std::optional<Obstacles::Touch> Obstacles::first_touch(const Eigen::Vector3d& from,
                                                       const Eigen::Vector3d& to) const {
  const Eigen::Vector3d way = to - from;
  const double length = way.norm();
  if (length == 0) return std::nullopt;
  std::optional<Touch> touch;
  if (to.z() < 0 && from.z() >= 0) {
    const double t = from.z() / (from.z() - to.z());
    touch = Touch{t, from + t * way, Contact::platform};
    touch->place.z() = 0;
  }
  if (const auto t = leaves_window(from, way); t && (!touch || *t < touch->t))
    touch = Touch{*t, from + *t * way, Contact::clamp};

  if (misses_mold(from, to)) return touch;
  const double early = back_off / length;
  const Eigen::Vector3d origin = from - early * way, direction = (1 + early) * way;
  if (const auto hit = rays_.first_hit(origin, direction)) {
    const Triangle& f = mold_.triangles[hit->triangle];
    const Eigen::Vector3d a = mold_.vertices[f[0]], b = mold_.vertices[f[1]], c = mold_.vertices[f[2]];
    const bool entering = (b - a).cross(c - a).dot(way) < 0;
    const double t = std::max(0.0, hit->t * (1 + early) - early);
    if (entering && (!touch || t < touch->t))
      touch = Touch{t, (1 - hit->u - hit->v) * a + hit->u * b + hit->v * c, Contact::mold};
  }
  return touch;
}

namespace {

TriangleMesh mesh_of(const Points& x, const std::vector<Triangle>& triangles) {
  TriangleMesh mesh{{}, triangles};
  for (Eigen::Index i = 0; i < x.cols(); ++i) mesh.vertices.push_back(x.col(i));
  return mesh;
}

}  // namespace

SheetAsObstacle::SheetAsObstacle(const Points& x, const std::vector<Triangle>& triangles)
    : mesh_(mesh_of(x, triangles)), rays_(mesh_, RayTree::quick) {}

bool SheetAsObstacle::possible(const Points& x, const std::vector<Triangle>& triangles,
                               const std::vector<char>& held) {
  return std::any_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
    const Eigen::Vector3d a = x.col(t[0]), b = x.col(t[1]), c = x.col(t[2]);
    return (b - a).cross(c - a).z() < 0 && !(held[t[0]] && held[t[1]] && held[t[2]]);
  });
}

std::optional<double> SheetAsObstacle::stops(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const Eigen::Vector3d way = 2 * (to - from);
  const double length = way.norm();
  if (length == 0) return std::nullopt;
  // The ray starts away from its own triangles and passes through parts that it meets from above.
  double started = std::min(1.0, back_off / length);
  for (int layer = 0; layer < 4; ++layer) {
    const auto hit = rays_.first_hit(from + started * way, (1 - started) * way);
    if (!hit) return std::nullopt;
    const Triangle& t = mesh_.triangles[hit->triangle];
    const Eigen::Vector3d &a = mesh_.vertices[t[0]], &b = mesh_.vertices[t[1]], &c = mesh_.vertices[t[2]];
    const double at = started + hit->t * (1 - started);
    if ((b - a).cross(c - a).dot(way) > 0) return std::min(1.0, at);
    started = at + back_off / length;
    if (started >= 1) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace vacuform
