// Smooth normals of a triangulation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// One unit vector a vertex: the mean of the normals of its triangles, weighted by their areas; +z where there is no
// area.
std::vector<Eigen::Vector3d> vertex_normals(const std::vector<Eigen::Vector3d>& vertices,
                                            const std::vector<Triangle>& triangles);

}  // namespace vacuform
