// Embree's scene of one mesh: what its ray and point queries run on. Embree's own types stay behind this header.
#pragma once

#include <Eigen/Core>

#include "worker/surface/triangle_mesh.hpp"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace vacuform {

enum class RayTree;  // ray_caster.hpp

// Copies the triangles, as floats relative to the middle of the mesh's bounding box. Queries never hit a mesh without
// triangles. Throws std::runtime_error or std::bad_alloc if Embree fails.
struct EmbreeScene {
  explicit EmbreeScene(const TriangleMesh& mesh, RayTree tree);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  RTCDeviceTy* device = nullptr;
  RTCSceneTy* scene = nullptr;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  const float* points = nullptr;      // of the scene, three for each vertex
  const unsigned* corners = nullptr;  // the same, three for each triangle
};

}  // namespace vacuform
