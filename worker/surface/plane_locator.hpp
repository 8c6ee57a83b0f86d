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

  // The triangle that holds the point; nothing where none does. Of several the first.
  std::optional<SheetPoint> find(const Eigen::Vector2d& point) const;

 private:
  std::size_t cell(const Eigen::Vector2d& point) const;

  const std::vector<Triangle>& triangles_;
  const std::vector<Eigen::Vector2d>& plane_;
  Eigen::Vector2d low_;
  double size_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<int>> cells_;  // triangles whose boxes meet the cell, ascending
};

}  // namespace vacuform
