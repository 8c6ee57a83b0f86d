// A model with one texture as a GLB. Internal to worker/sample and its benchmark.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

typedef struct _cairo_surface cairo_surface_t;

namespace vacuform {

// The pixels of an image surface of format RGB24 as PNG, RGB.
std::vector<std::uint8_t> png_of(cairo_surface_t* surface);

// `mesh` in mm, Z up; +Y is up in the file, and lengths are metres. `uv` of each vertex, as in glTF: v down. `picture`: PNG,
// or JPEG, which readers know by its first bytes.
std::vector<std::uint8_t> textured_glb(const TriangleMesh& mesh, const std::vector<Eigen::Vector2d>& uv,
                                       const std::vector<std::uint8_t>& picture, const char* name);

}  // namespace vacuform
