#include "worker/surface/vertex_normals.hpp"

#include <Eigen/Geometry>

namespace vacuform {

std::vector<Eigen::Vector3d> vertex_normals(const std::vector<Eigen::Vector3d>& vertices,
                                            const std::vector<Triangle>& triangles) {
  const auto at = [&](int v) -> const Eigen::Vector3d& { return vertices[v]; };
  std::vector<Eigen::Vector3d> normals(vertices.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : triangles) {
    const Eigen::Vector3d& from = at(t[0]);
    const Eigen::Vector3d normal = (at(t[1]) - from).cross(at(t[2]) - from);
    for (const int v : t) normals[v] += normal;
  }
  for (auto& n : normals) n = n.squaredNorm() > 0 ? n.normalized() : Eigen::Vector3d(0, 0, 1);
  return normals;
}

}  // namespace vacuform
