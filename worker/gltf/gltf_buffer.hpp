// Writes binary glTF 2.0 (GLB): the binary part, with the views and accessors that describe it, and the file around it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "worker/gltf/little_endian.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

using GltfJson = nlohmann::ordered_json;

// Numbers that the glTF specification assigns.
namespace gltf {
inline constexpr int of_floats = 5126, of_uint32 = 5125, for_vertices = 34962, for_indices = 34963;
inline constexpr int linear = 9729, linear_mipmaps = 9987, clamp_to_edge = 33071;
}  // namespace gltf

// The binary part of the file and what describes it. Every view begins at a multiple of four bytes.
struct GltfBuffer {
  std::vector<std::uint8_t> bytes;
  GltfJson views = GltfJson::array(), accessors = GltfJson::array();

  // Makes a view of the bytes that were appended since `start`; `target` 0: none.
  std::size_t add_view(std::size_t start, int target);

  // Adds `size` numbers (1 to 3) for each vertex, from value(vertex, which). Numbers that are not finite become 0.
  // Returns the number of the accessor.
  template <class Value>
  std::size_t add_attribute(std::size_t count, std::size_t size, Value&& value) {
    constexpr const char* types[] = {"SCALAR", "VEC2", "VEC3"};
    std::vector<float> least(size, INFINITY), most(size, -INFINITY);
    const std::size_t start = bytes.size();
    bytes.reserve(start + 4 * size * count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < size; ++k) {
        const double exact = value(i, k);
        const float v = std::isfinite(exact) ? static_cast<float>(exact) : 0.0f;
        least[k] = std::min(least[k], v), most[k] = std::max(most[k], v);
        append(bytes, static_cast<double>(v));
      }
    accessors.push_back({{"bufferView", add_view(start, gltf::for_vertices)},
                         {"componentType", gltf::of_floats},
                         {"count", count},
                         {"type", types[size - 1]},
                         {"min", least},
                         {"max", most}});
    return accessors.size() - 1;
  }

  std::size_t add_triangles(const std::vector<Triangle>& triangles);
  // Adds the image. Returns its entry for the list of images.
  GltfJson add_png(const char* name, const std::vector<std::uint8_t>& png);
};

// A node's matrix, by columns: from (x, y, z) in mm, z up and +y in front, to (-x, z, y) in metres: glTF defines +Y as up and
// +Z as the front.
GltfJson gltf_matrix_from_mm();

// The file: `json`, with the buffer's members added, and the buffer.
std::vector<std::uint8_t> glb_of(GltfJson json, GltfBuffer buffer);

}  // namespace vacuform
