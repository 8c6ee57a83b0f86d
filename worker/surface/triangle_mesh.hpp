// The triangle mesh that every stage uses.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace vacuform {

using Triangle = std::array<int, 3>;  // vertex indices, counter-clockwise seen from outside

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  // mm
  std::vector<Triangle> triangles;
};

// The normal of a triangle times its area, mm^2.
inline Eigen::Vector3d area_vector(const TriangleMesh& mesh, const Triangle& t) {
  const auto& a = mesh.vertices[t[0]];
  const auto& b = mesh.vertices[t[1]];
  const auto& c = mesh.vertices[t[2]];
  return (b - a).cross(c - a) / 2;
}

}  // namespace vacuform
