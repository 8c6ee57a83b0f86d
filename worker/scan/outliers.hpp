// Stray vertices: a few points far from all others, as scanners and file converters leave them.
#pragma once

#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Removes the triangles of a welded mesh that have a corner farther from the box of the middle 96 % of the vertices
// (along each axis) than its diagonal, if fewer than a hundredth of the vertices are that far away. Returns the places
// of those corners, the farthest first. Removes nothing if more of the surface lies far away than near. O(n).
std::vector<Eigen::Vector3d> drop_outliers(TriangleMesh& mesh);

}  // namespace vacuform
