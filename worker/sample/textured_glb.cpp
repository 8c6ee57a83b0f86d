#include "worker/sample/textured_glb.hpp"

#include <utility>

#include "worker/gltf/gltf_buffer.hpp"

namespace vacuform {

std::vector<std::uint8_t> textured_glb(const TriangleMesh& mesh, const std::vector<Eigen::Vector2d>& uv,
                                       const std::vector<std::uint8_t>& picture, const char* name) {
  const auto& vertices = mesh.vertices;
  GltfBuffer buffer;
  GltfJson primitive;
  primitive["attributes"]["POSITION"] = buffer.add_attribute(
      vertices.size(), 3,
      [&](std::size_t v, std::size_t k) { return vertices[v][static_cast<Eigen::Index>(k)]; });
  primitive["attributes"]["TEXCOORD_0"] = buffer.add_attribute(
      vertices.size(), 2, [&](std::size_t v, std::size_t k) { return uv[v][static_cast<Eigen::Index>(k)]; });
  primitive["indices"] = buffer.add_triangles(mesh.triangles);
  primitive["material"] = 0;
  GltfJson json = {{"asset", {{"version", "2.0"}, {"generator", "vacuform sample"}}},
                   {"scene", 0},
                   {"scenes", GltfJson::array({GltfJson{{"nodes", GltfJson::array({0})}}})}};
  json["nodes"] = GltfJson::array({GltfJson{{"name", name}, {"mesh", 0}, {"matrix", gltf_matrix_from_mm()}}});
  json["meshes"] = GltfJson::array({GltfJson{{"primitives", GltfJson::array({primitive})}}});
  json["materials"] = GltfJson::array({GltfJson{
      {"pbrMetallicRoughness",
       {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.6}}}}});
  json["textures"] = GltfJson::array({GltfJson{{"sampler", 0}, {"source", 0}}});
  json["images"] = GltfJson::array({buffer.add_png(name, picture)});
  json["samplers"] = GltfJson::array({GltfJson{{"magFilter", gltf::linear},
                                               {"minFilter", gltf::linear_mipmaps},
                                               {"wrapS", gltf::clamp_to_edge},
                                               {"wrapT", gltf::clamp_to_edge}}});
  return glb_of(std::move(json), std::move(buffer));
}

}  // namespace vacuform
