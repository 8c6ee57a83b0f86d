// Cutting a closed mesh at a horizontal plane and closing the cut flat.
#pragma once

#include <optional>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The part of a closed mesh above z = height, with flat caps facing down; the mesh itself when all of it is
// above. Vertices nearer than 1e-3 mm to the plane count as that far above it. Empty optional: the border of
// the cut crosses itself (the mesh intersects itself there).
std::optional<TriangleMesh> cut_above(const TriangleMesh& mesh, double height);

// Triangles (seen from below counter-clockwise) that fill the loops, taken as outlines and holes by the
// even-odd rule in their projection along z. Empty optional: two loops cross or touch. Constrained Delaunay
// triangulation.
std::optional<std::vector<Triangle>> flat_cap(const std::vector<Eigen::Vector3d>& vertices,
                                              const std::vector<std::vector<int>>& loops);

}  // namespace vacuform
