// Where a mold stands and how it is turned while it is measured, both independent of how the scan was turned about the
// vertical axis.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
};

// The smallest circle that holds all vertices seen from above. Found to 1e-12 of its radius by adding the farthest
// point to the at most three that define the circle, as in Welzl 1991, "Smallest enclosing disks". O(n) for each of a
// few rounds.
Circle enclosing_circle(const TriangleMesh& mesh);

// The longest side of the upright box around the mesh that is as small as possible seen from above: the same however
// the scan is turned about the vertical axis. O(n log n).
double longest_side(const TriangleMesh& upright);

// Leaves heights exactly as they are.
Eigen::Matrix3d turn_about_z(double radians);

// The turn about z that brings the horizontal principal axes of the surface to x (the longer one) and y. A turned scan
// is brought to the same place, a mirrored one to the mirror image in x = 0 or y = 0. Two turns do so; the one with
// more of the surface far out towards +x is used. If both axes are equally long, the turn is arbitrary but repeatable.
Eigen::Matrix3d principal_turn(const TriangleMesh& mesh);

}  // namespace vacuform
