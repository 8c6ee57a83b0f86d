// A model with one texture as a GLB. Internal to worker/sample and its benchmark.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// `mesh` in mm, Z up, front +Y; +Y is up in the file, +Z in front, and lengths are metres. `uv` of each vertex, as in glTF: v down. `picture`: PNG,
// or JPEG, which readers know by its first bytes.
std::vector<std::uint8_t> textured_glb(const TriangleMesh& mesh, const std::vector<Eigen::Vector2d>& uv,
                                       const std::vector<std::uint8_t>& picture, const char* name);

}  // namespace vacuform
