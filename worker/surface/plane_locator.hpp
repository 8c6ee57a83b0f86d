// Which triangle of a triangulated plane region holds a point.
#pragma once

#include <optional>
#include <vector>

#include "worker/surface/sheet_point.hpp"

namespace vacuform {

// Finds points of a triangulated plane region by a grid of boxes: O(1) a point for the sheet's even triangles.
class PlaneLocator {
 public:
  // `triangles` (those of `which`, or all) over `plane`; both must outlive this.
  PlaneLocator(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector2d>& plane);
  PlaneLocator(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector2d>& plane,
               const std::vector<int>& which);

  // The first triangle that contains the point, or nothing.
  std::optional<SheetPoint> find(const Eigen::Vector2d& point) const;
  // The same, otherwise the nearest triangle within `beyond`, with weights extrapolated in its plane.
  std::optional<SheetPoint> nearest(const Eigen::Vector2d& point, double beyond) const;

 private:
  struct Hit;
  std::size_t cell(const Eigen::Vector2d& point) const;
  void look(int column, int row, const Eigen::Vector2d& point, Hit& hit) const;

  const std::vector<Triangle>& triangles_;
  const std::vector<Eigen::Vector2d>& plane_;
  Eigen::Vector2d low_;
  double size_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<std::size_t> first_;  // of each cell, in entries_
  std::vector<int> entries_;        // triangles whose boxes meet the cell, ascending
};

}  // namespace vacuform
