#include "worker/surface/plane_locator.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "worker/numerics/plane.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

constexpr double rounding = 1e-9;  // a weight this much below 0 still counts as on the triangle

std::vector<int> all_of(const std::vector<Triangle>& triangles) {
  std::vector<int> which(triangles.size());
  std::iota(which.begin(), which.end(), 0);
  return which;
}

}  // namespace

PlaneLocator::PlaneLocator(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector2d>& plane)
    : PlaneLocator(triangles, plane, all_of(triangles)) {}

PlaneLocator::PlaneLocator(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector2d>& plane,
                           const std::vector<int>& which)
    : triangles_(triangles), plane_(plane) {
  std::vector<std::pair<int, Eigen::AlignedBox2d>> boxes;
  Eigen::AlignedBox2d all;
  for (const int k : which) {
    Eigen::AlignedBox2d box;
    bool finite = true;
    for (const int v : triangles[index(k)])
      finite &= plane[index(v)].allFinite(), box.extend(plane[index(v)]);
    if (finite) boxes.emplace_back(k, box), all.extend(box);
  }
  if (boxes.empty()) return;
  constexpr double most_cells = 2000;  // along a side
  const Eigen::Vector2d size = all.sizes();
  low_ = all.min();
  size_ = std::max(
      {1e-9, std::sqrt(2 * size.prod() / static_cast<double>(boxes.size())), size.maxCoeff() / most_cells});
  columns_ = static_cast<int>(size.x() / size_) + 1;
  rows_ = static_cast<int>(size.y() / size_) + 1;
  const auto columns = static_cast<std::size_t>(columns_);
  first_.assign(columns * index(rows_) + 1, 0);
  const auto each_cell = [&](const Eigen::AlignedBox2d& box, auto&& visit) {
    const std::size_t first = cell(box.min()), last = cell(box.max());
    for (std::size_t y = first / columns; y <= last / columns; ++y)
      for (std::size_t x = first % columns; x <= last % columns; ++x) visit(y * columns + x);
  };
  for (const auto& [k, box] : boxes) each_cell(box, [&](std::size_t c) { ++first_[c + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  entries_.resize(first_.back());
  std::vector<std::size_t> fill = first_;
  for (const auto& [k, box] : boxes) each_cell(box, [&, k = k](std::size_t c) { entries_[fill[c]++] = k; });
}

std::size_t PlaneLocator::cell(const Eigen::Vector2d& point) const {
  const auto along = [&](int k, int count) {
    return std::clamp(static_cast<int>((point[k] - low_[k]) / size_), 0, count - 1);
  };
  return static_cast<std::size_t>(along(1, rows_)) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(along(0, columns_));
}

std::optional<SheetPoint> PlaneLocator::find(const Eigen::Vector2d& point) const {
  if (entries_.empty() || !point.allFinite()) return std::nullopt;
  const std::size_t at = cell(point);
  for (std::size_t i = first_[at]; i < first_[at + 1]; ++i) {
    const int k = entries_[i];
    const Triangle& t = triangles_[k];
    const Eigen::Vector2d a = plane_[index(t[0])], b = plane_[index(t[1])] - a, c = plane_[index(t[2])] - a,
                          p = point - a;
    const double whole = cross(b, c);
    const double u = (cross(p, c)) / whole, v = (cross(b, p)) / whole;
    if (u >= -rounding && v >= -rounding && u + v <= 1 + rounding)
      return SheetPoint{k, Eigen::Vector3d(1 - u - v, u, v)};
  }
  return std::nullopt;
}

struct PlaneLocator::Hit {
  std::optional<SheetPoint> point;
  double off = HUGE_VAL;  // outside the triangle
};

void PlaneLocator::look(int column, int row, const Eigen::Vector2d& point, Hit& hit) const {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  const std::size_t at = index(row) * static_cast<std::size_t>(columns_) + index(column);
  for (std::size_t i = first_[at]; i < first_[at + 1] && hit.off > 0; ++i) {
    const Triangle& t = triangles_[index(entries_[i])];
    const Eigen::Vector2d &a = plane_[index(t[0])], &b = plane_[index(t[1])], &c = plane_[index(t[2])];
    const double twice = cross(b - a, c - a);
    if (!(std::abs(twice) > 1e-12)) continue;
    const Eigen::Vector3d weights(cross(b - point, c - point) / twice, cross(c - point, a - point) / twice,
                                  cross(a - point, b - point) / twice);
    // How far it is outside of each side: the negative weight times the height of the corner opposite.
    const Eigen::Vector3d sides((c - b).norm(), (a - c).norm(), (b - a).norm());
    double off = 0;
    for (int s = 0; s < 3; ++s) off = std::max(off, -weights[s] * std::abs(twice) / sides[s]);
    if (off < hit.off) hit = {SheetPoint{entries_[i], weights}, off};
  }
}

std::optional<SheetPoint> PlaneLocator::nearest(const Eigen::Vector2d& point, double beyond) const {
  if (entries_.empty() || !point.allFinite()) return std::nullopt;
  const Eigen::Vector2d at = (point - low_) / size_;
  if (at.minCoeff() < -1e6 || at.maxCoeff() > 1e6) return std::nullopt;
  const int column = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(at.y()));
  Hit hit;
  look(std::clamp(column, 0, columns_ - 1), std::clamp(row, 0, rows_ - 1), point, hit);
  if (hit.off > 0) {
    const int around = 1 + static_cast<int>(std::min(beyond / size_, 50.0));
    for (int y = row - around; y <= row + around; ++y)
      for (int x = column - around; x <= column + around; ++x) look(x, y, point, hit);
  }
  return hit.off > beyond ? std::nullopt : hit.point;
}

}  // namespace vacuform
