#include "worker/gltf/gltf_buffer.hpp"

namespace vacuform {

namespace {

constexpr std::uint32_t json_chunk = 0x4e4f534a, binary_chunk = 0x004e4942;

}  // namespace

std::size_t GltfBuffer::add_view(std::size_t start, int target) {
  GltfJson view = {{"buffer", 0}, {"byteOffset", start}, {"byteLength", bytes.size() - start}};
  if (target != 0) view["target"] = target;
  views.push_back(std::move(view));
  bytes.resize((bytes.size() + 3) / 4 * 4, 0);
  return views.size() - 1;
}

std::size_t GltfBuffer::add_triangles(const std::vector<Triangle>& triangles) {
  const std::size_t start = bytes.size();
  bytes.reserve(start + 12 * triangles.size());
  for (const Triangle& t : triangles)
    for (const int v : t) append(bytes, static_cast<std::uint32_t>(v));
  accessors.push_back({{"bufferView", add_view(start, gltf::for_indices)},
                       {"componentType", gltf::of_uint32},
                       {"count", 3 * triangles.size()},
                       {"type", "SCALAR"}});
  return accessors.size() - 1;
}

GltfJson GltfBuffer::add_png(const char* name, const std::vector<std::uint8_t>& png) {
  const std::size_t start = bytes.size();
  bytes.insert(bytes.end(), png.begin(), png.end());
  return {{"name", name}, {"mimeType", "image/png"}, {"bufferView", add_view(start, 0)}};
}

GltfJson gltf_matrix_from_mm() {
  return {-0.001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.001, 0.0, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
}

// The header and the two chunks; each chunk is a multiple of four bytes long.
std::vector<std::uint8_t> glb_of(GltfJson json, GltfBuffer buffer) {
  json["accessors"] = std::move(buffer.accessors);
  json["bufferViews"] = std::move(buffer.views);
  json["buffers"] = GltfJson::array({GltfJson{{"byteLength", buffer.bytes.size()}}});
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::uint8_t> out{'g', 'l', 'T', 'F'};
  out.reserve(28 + text.size() + buffer.bytes.size());
  append(out, std::uint32_t{2});
  append(out, static_cast<std::uint32_t>(28 + text.size() + buffer.bytes.size()));
  append(out, static_cast<std::uint32_t>(text.size()));
  append(out, json_chunk);
  out.insert(out.end(), text.begin(), text.end());
  append(out, static_cast<std::uint32_t>(buffer.bytes.size()));
  append(out, binary_chunk);
  out.insert(out.end(), buffer.bytes.begin(), buffer.bytes.end());
  return out;
}

}  // namespace vacuform
