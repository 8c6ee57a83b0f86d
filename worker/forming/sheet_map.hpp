// Where any point of the flat sheet lies on the formed one.
#pragma once

#include <optional>
#include <vector>

#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// A triangle of the sheet and weights of its corners that sum to 1.
struct SheetPoint {
  int triangle;
  Eigen::Vector3d weights;
};

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

template <class Values>
auto interpolate(const std::vector<Triangle>& triangles, const SheetPoint& at, const Values& values) {
  const Triangle& t = triangles[static_cast<std::size_t>(at.triangle)];
  using Value = std::decay_t<decltype(values[0])>;
  return Value(at.weights[0] * values[static_cast<std::size_t>(t[0])] +
               at.weights[1] * values[static_cast<std::size_t>(t[1])] +
               at.weights[2] * values[static_cast<std::size_t>(t[2])]);
}

// The formed place of points of the sheet, by linear interpolation in its triangles. Keeps a reference to the sheet.
class SheetMap {
 public:
  explicit SheetMap(const FormedSheet& sheet) : sheet_(sheet), locator_(sheet.triangles, sheet.rest) {}

  // Nothing off the sheet.
  std::optional<Eigen::Vector3d> operator()(const Eigen::Vector2d& rest) const;

 private:
  const FormedSheet& sheet_;
  PlaneLocator locator_;
};

}  // namespace vacuform
