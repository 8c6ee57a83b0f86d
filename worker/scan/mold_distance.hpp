// Distances from points to the mold's surface.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "worker/scan/ray_caster.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The closest point on a set of triangles by a descent of Embree's BVH; the distance to each candidate
// triangle is computed in double precision (Ericson 2005, "Real-time collision detection", 5.1.5).
class MoldDistance {
 public:
  explicit MoldDistance(const TriangleMesh& mesh);  // keeps a reference
  // `rays`: of the same mesh; saves building a second tree.
  MoldDistance(const TriangleMesh& mesh, const RayCaster& rays);

  // Infinite for a mesh without triangles. Thread safe and deterministic.
  double operator()(const Eigen::Vector3d& point) const;
  // The same, sooner for points in a row: `triangle` is the closest one of the point before, or -1, and becomes that of
  // this point.
  double operator()(const Eigen::Vector3d& point, int& triangle) const;
  // The closest point itself. The mesh must have triangles.
  Eigen::Vector3d nearest(const Eigen::Vector3d& point) const;
  // Whether the distance is less than this many mm; stops at the first triangle that is near enough.
  bool within(const Eigen::Vector3d& point, double distance_mm) const;

  // The closest point as barycentric weights of the corners of a triangle of the mesh; nothing if it is farther than
  // `reach_mm`. If several triangles are equally close, the choice is always the same. Thread safe and deterministic.
  struct Nearest {
    int triangle;
    Eigen::Vector3d weights;
    double distance_mm;
  };
  std::optional<Nearest> nearest(const Eigen::Vector3d& point, double reach_mm) const {
    return nearest(point, reach_mm, -1);
  }
  // The same, sooner if `guess` is close: a triangle, which is the choice if no other is closer, or -1.
  std::optional<Nearest> nearest(const Eigen::Vector3d& point, double reach_mm, int guess) const;

 private:
  const TriangleMesh& mesh_;
  std::shared_ptr<const EmbreeScene> scene_;
};

}  // namespace vacuform
