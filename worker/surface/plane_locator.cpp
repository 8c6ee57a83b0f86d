#include "worker/surface/plane_locator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

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
  low_ = Eigen::Vector2d::Constant(HUGE_VAL);
  Eigen::Vector2d high = -low_;
  for (const int k : which)
    for (const int v : triangles[static_cast<std::size_t>(k)]) {
      low_ = low_.cwiseMin(plane[static_cast<std::size_t>(v)]);
      high = high.cwiseMax(plane[static_cast<std::size_t>(v)]);
    }
  if (which.empty()) return;
  const Eigen::Vector2d size = high - low_;
  size_ = std::max(1e-9, std::sqrt(2 * size.x() * size.y() / static_cast<double>(which.size())));
  columns_ = static_cast<int>(size.x() / size_) + 1;
  rows_ = static_cast<int>(size.y() / size_) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (const int k : which) {
    Eigen::Vector2d least = Eigen::Vector2d::Constant(HUGE_VAL), most = -least;
    for (const int v : triangles[static_cast<std::size_t>(k)]) {
      least = least.cwiseMin(plane[static_cast<std::size_t>(v)]);
      most = most.cwiseMax(plane[static_cast<std::size_t>(v)]);
    }
    const std::size_t first = cell(least), last = cell(most);
    const auto columns = static_cast<std::size_t>(columns_);
    for (std::size_t y = first / columns; y <= last / columns; ++y)
      for (std::size_t x = first % columns; x <= last % columns; ++x) cells_[y * columns + x].push_back(k);
  }
}

std::size_t PlaneLocator::cell(const Eigen::Vector2d& point) const {
  const auto along = [&](int k, int count) {
    return std::clamp(static_cast<int>((point[k] - low_[k]) / size_), 0, count - 1);
  };
  return static_cast<std::size_t>(along(1, rows_)) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(along(0, columns_));
}

std::optional<SheetPoint> PlaneLocator::find(const Eigen::Vector2d& point) const {
  if (cells_.empty() || !point.allFinite()) return std::nullopt;
  for (const int k : cells_[cell(point)]) {
    const Triangle& t = triangles_[static_cast<std::size_t>(k)];
    const Eigen::Vector2d a = plane_[static_cast<std::size_t>(t[0])],
                          b = plane_[static_cast<std::size_t>(t[1])] - a,
                          c = plane_[static_cast<std::size_t>(t[2])] - a, p = point - a;
    const double whole = b.x() * c.y() - b.y() * c.x();
    const double u = (p.x() * c.y() - p.y() * c.x()) / whole, v = (b.x() * p.y() - b.y() * p.x()) / whole;
    if (u >= -rounding && v >= -rounding && u + v <= 1 + rounding)
      return SheetPoint{k, Eigen::Vector3d(1 - u - v, u, v)};
  }
  return std::nullopt;
}

}  // namespace vacuform
