// How far a loop comes out from the shape that was drawn, whatever that shape is. Internal to worker/inspection.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vacuform {

struct ShapeDistance {
  double largest_mm = 0;  // the Hausdorff distance of the two lines
  double mean_mm = 0;     // over the length of the line that was made
};

// Between two closed lines that run in the same direction, after the rotation and translation that fits them best
// (least squares). Their sizes are not fitted. The last point of a line is joined to the first. Deterministic.
ShapeDistance shape_distance(const std::vector<Eigen::Vector2d>& made,
                             const std::vector<Eigen::Vector2d>& drawn);

// A loop given by its geodesic polar coordinates about a point of a surface, in the plane: directions stay, and radii
// become those of the map that is true to area on a surface of constant curvature (Lambert's), whose curvature is such
// that the loop encloses `area_mm2`, as it does on the surface. On a flat surface it is the loop itself.
std::vector<Eigen::Vector2d> true_to_area(std::vector<Eigen::Vector2d> polar, double area_mm2);

}  // namespace vacuform
