// The triangle mesh that every stage uses.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace vacuform {

using Triangle = std::array<int, 3>;  // vertex indices, counter-clockwise seen from outside

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  // mm
  std::vector<Triangle> triangles;
};

}  // namespace vacuform
