// Embree's scene of one mesh: what its ray and point queries run on. Embree's own types stay behind this header.
#pragma once

#include <Eigen/Core>

#include "worker/surface/triangle_mesh.hpp"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace vacuform {

// Copies the triangles, as floats relative to the middle of the mesh's bounding box. A mesh without triangles gives a
// scene that nothing meets. Throws std::runtime_error or std::bad_alloc when Embree cannot.
struct EmbreeScene {
  explicit EmbreeScene(const TriangleMesh& mesh);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  RTCDeviceTy* device = nullptr;
  RTCSceneTy* scene = nullptr;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

}  // namespace vacuform
