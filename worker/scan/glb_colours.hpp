// The colours of a GLB file: base colour textures and factors, and vertex colours. Internal to worker/scan.
//
// Supports materials with pbrMetallicRoughness, or KHR_materials_pbrSpecularGlossiness of older files, any set of
// texture coordinates, KHR_texture_transform, the wrapping of the sampler, and COLOR_0 (linear light, as in glTF).
// Where the base colour is black, the emissive texture and factor are the colour: programs write unlit scans so. Images must be PNG or JPEG inside the file; KTX2 and WebP are rejected by name.
#pragma once

#include <map>

#include "worker/scan/glb_primitive.hpp"
#include "worker/scan/scan_colours.hpp"

namespace vacuform {

class GlbColours {
 public:
  explicit GlbColours(const GlbFile& file) : file_(file) {}

  // Adds the colours of a primitive whose vertices start at `first_vertex` and whose triangles start at
  // `first_triangle`. Errors: corrupt_file, unsupported_format.
  Result<void> add(const GlbPrimitive& part, const nlohmann::json& primitive, const TriangleMesh& mesh,
                   std::size_t first_vertex, std::size_t first_triangle);
  // The colours of all primitives; nothing if no triangle has a texture, a factor other than white, or a vertex colour.
  std::optional<ScanColours> take();
  // What was done with light that materials give off. Sentences without their ends.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  // A material, and the map from given texture coordinates to those of its image: uv = linear * given + shift.
  struct Laid {
    int material = 0;
    std::uint64_t set = 0;
    Eigen::Matrix2f linear = Eigen::Matrix2f::Identity();
    Eigen::Vector2f shift = Eigen::Vector2f::Zero();
  };
  Result<void> lay_emission(const nlohmann::json& given, bool black, ScanMaterial& material, Laid& laid);
  void note(std::string text);
  Result<Laid> laid_material(std::optional<std::uint64_t> index);
  Result<void> lay_texture(const nlohmann::json& texture_info, ScanMaterial& material, Laid& laid);
  Result<int> image(std::uint64_t index);
  Result<void> add_uv(const GlbPrimitive& part, const Laid& laid, const TriangleMesh& mesh,
                      std::size_t first_vertex, std::size_t first_triangle);
  Result<void> add_vertex_colours(const GlbPrimitive& part, std::size_t first_vertex, std::size_t vertices);

  const GlbFile& file_;
  ScanColours colours_;
  std::map<std::uint64_t, Laid> materials_;  // by the index in the file
  std::map<std::uint64_t, int> images_;
  std::vector<std::string> notes_;
  std::uint64_t image_bytes_ = 0;
  std::optional<Laid> plain_;  // of primitives without a material
};

}  // namespace vacuform
