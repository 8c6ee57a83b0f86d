// A line on the flat sheet as it lies on the formed part, and strips of ink beside it that are as wide there as they are asked to
// be.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "worker/pattern/area.hpp"
#include "worker/surface/inked_surface.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

class PartLine {
 public:
  struct Point {
    double along = 0;  // from the beginning, mm on the part
    Eigen::Vector2d rest{0, 0};
    SheetPoint at{};
    Eigen::Vector3d place{0, 0, 0};
    Eigen::Vector3d left{0, 0, 0};  // a unit vector in the triangle's plane, across the line
  };

  // Points of the flat sheet some tenths of a millimetre apart. Those off the sheet are left out. Keeps a reference to the
  // surface. `locator` is that of the flat sheet.
  PartLine(const InkedSurface& surface, const PlaneLocator& locator,
           const std::vector<Eigen::Vector2d>& line);

  const std::vector<Point>& points() const { return points_; }
  double length() const { return points_.empty() ? 0 : points_.back().along; }

  // So far to the left of a point along a straight way over the part; nothing off the sheet.
  std::optional<SheetPoint> beside(const Point& point, double left_mm) const;

  // Between two lengths along the line and two distances to its left, which depend on the length: sheet coordinates.
  using Left = std::function<double(double along)>;
  Area strip(double from, double to, const Left& right_edge, const Left& left_edge) const;

  // The line so far to the left, between two lengths; sheet coordinates.
  std::vector<Eigen::Vector2d> beside_line(double from, double to, const Left& left) const;

  const InkedSurface& surface() const { return surface_; }
  Point at(double along) const;  // between its points; beyond an end that end

 private:
  std::vector<Point> between(double from, double to) const;

  const InkedSurface& surface_;
  const PlaneLocator& locator_;
  std::vector<Point> points_;
};

}  // namespace vacuform
