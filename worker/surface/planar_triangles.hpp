// Triangles that cover what outlines in a plane enclose.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

struct PlanarTriangles {
  // Those of the rings in their order, then places where sides cross. Of two at the same place only the first is used.
  std::vector<Eigen::Vector2d> points;
  std::vector<Triangle> triangles;  // counter-clockwise
  bool simple = true;               // no two points lie at the same place, and no sides cross
};
// What an odd number of the closed rings surrounds, as a constrained Delaunay triangulation. Deterministic.
PlanarTriangles triangulate(const std::vector<std::vector<Eigen::Vector2d>>& rings);

}  // namespace vacuform
