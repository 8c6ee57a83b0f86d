// Distances from points to the mold's surface.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The closest point on a set of triangles by a descent of Embree's BVH; the distance to each candidate
// triangle is computed in double precision (Ericson 2005, "Real-time collision detection", 5.1.5).
class MoldDistance {
 public:
  explicit MoldDistance(const TriangleMesh& mesh);  // keeps a reference
  ~MoldDistance();

  // Infinite for a mesh without triangles. Thread safe and deterministic.
  double operator()(const Eigen::Vector3d& point) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace vacuform
