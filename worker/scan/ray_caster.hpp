// Ray queries against a fixed set of triangles (Embree's BVH; Wald et al. 2014, "Embree: a kernel framework for
// efficient CPU ray tracing"). Coordinates are kept as floats relative to the mesh's centre, so a hit is exact to
// about 1e-5 of the mesh's size; the robust traversal lets no ray slip between two triangles that share an edge. The figures of
// a hit are the same on every processor unless its triangle is seen exactly edge-on; of triangles that a ray meets on their common
// edge, each processor may name another.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

struct EmbreeScene;

// `quick` takes a quarter of the time to prepare (4 instead of 16 ms for 80,000 triangles), for few queries. The hits are
// the same.
enum class RayTree { tight, quick };

class RayCaster {
 public:
  struct Hit {
    double t;      // along the direction as given, in (0, 1]
    int triangle;  // index into the mesh's triangles
    double u, v;   // barycentric: (1 - u - v) a + u b + v c
  };

  // Copies what it needs of the mesh. A mesh without triangles is allowed and is never hit.
  explicit RayCaster(const TriangleMesh& mesh, RayTree tree = RayTree::tight);

  // The first hit on the segment from origin to origin + direction. Thread safe and deterministic.
  std::optional<Hit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  // For other queries on the same mesh.
  const std::shared_ptr<const EmbreeScene>& scene() const { return scene_; }

 private:
  std::shared_ptr<const EmbreeScene> scene_;
};

// Whether a ray from the point straight up leaves the mesh before it enters it: the point lies in a closed surface, or
// under a sheet. `rays` belongs to the mesh; `height` exceeds the height of the mesh.
bool lies_below(const TriangleMesh& mesh, const RayCaster& rays, const Eigen::Vector3d& point, double height);

}  // namespace vacuform
