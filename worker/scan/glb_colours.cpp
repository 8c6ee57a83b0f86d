#include "worker/scan/glb_colours.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace vacuform {

using nlohmann::json;

namespace {

constexpr float largest_uv = 1e6f;

// Component k of element i. Integers are fractions of their largest value.
float fraction(const GlbView& view, std::uint64_t i, std::uint64_t k) {
  const std::uint8_t* at = view.data + i * view.stride;
  if (view.component == 5126) return std::bit_cast<float>(u32(Bytes(at, 4 * k + 4), 4 * k));
  if (view.component == 5121) return static_cast<float>(at[k]) / 255;
  return static_cast<float>(at[2 * k] | at[2 * k + 1] << 8) / 65535;
}

bool numbers(const json& object, const char* key, std::size_t count, float* values) {
  const auto it = object.find(key);
  if (it == object.end()) return true;
  if (!it->is_array() || it->size() < count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(*it)[i].is_number()) return false;
    values[i] = (*it)[i].get<float>();
    if (!std::isfinite(values[i])) return false;
  }
  return true;
}

Wrap wrap_of(const json* sampler, const char* key) {
  const auto mode = sampler ? whole(*sampler, key, 10497) : std::optional<std::uint64_t>();
  return mode == 33071 ? Wrap::clamp : mode == 33648 ? Wrap::mirror : Wrap::repeat;
}

}  // namespace

Result<int> GlbColours::image(std::uint64_t index) {
  if (const auto it = images_.find(index); it != images_.end()) return it->second;
  const std::string name = "image " + std::to_string(index);
  const json* image = nth(file_.root, "images", index);
  if (!image) return corrupt("the GLB file has no " + name, file_.where);
  if (image->contains("uri"))
    return fail(Code::unsupported_format, name + " of the GLB file lies outside of it", file_.where,
                "export one self-contained GLB, with its textures inside");
  const json* view = nth(file_.root, "bufferViews", whole(*image, "bufferView"));
  if (!view) return corrupt(name + " of the GLB file has no buffer view", file_.where);
  VACUFORM_TRY(bytes, file_.bytes_of(*view, name));
  // Images that share their bytes would take many times the memory of the file.
  image_bytes_ += bytes.size();
  if (image_bytes_ > file_.binary.size())
    return corrupt("the images of the GLB file overlap each other", file_.where);
  colours_.images.push_back({name, {bytes.begin(), bytes.end()}});
  return images_[index] = static_cast<int>(colours_.images.size()) - 1;
}

Result<void> GlbColours::lay_texture(const json& info, ScanMaterial& material, Laid& laid) {
  const auto bad = [&] {
    return corrupt("a texture of the GLB file's materials is not of the documented form", file_.where);
  };
  const auto index = whole(info, "index"), set = whole(info, "texCoord", 0);
  const json* texture = nth(file_.root, "textures", index);
  if (!texture || !set) return bad();
  laid.set = *set;
  if (const json* extensions = child(info, "extensions"))
    if (const json* transform = child(*extensions, "KHR_texture_transform")) {
      float turn = 0;
      const auto own_set = whole(*transform, "texCoord", laid.set);
      Eigen::Vector2f scale(1, 1);
      if (!own_set || !numbers(*transform, "offset", 2, laid.shift.data()) ||
          !numbers(*transform, "scale", 2, scale.data()))
        return bad();
      if (const auto it = transform->find("rotation"); it != transform->end()) {
        if (!it->is_number() || !std::isfinite(turn = it->get<float>())) return bad();
      }
      laid.set = *own_set;
      // v runs down, so this turns the coordinates counter-clockwise as one sees them.
      laid.linear << std::cos(turn), std::sin(turn), -std::sin(turn), std::cos(turn);
      laid.linear *= scale.asDiagonal();
    }
  const auto source = whole(*texture, "source");
  if (!source) {
    const json* extensions = child(*texture, "extensions");
    for (const auto& [extension, format] :
         {std::pair{"KHR_texture_basisu", "KTX2"}, std::pair{"EXT_texture_webp", "WebP"}})
      if (extensions && extensions->contains(extension))
        return fail(Code::unsupported_format,
                    std::string("a texture of the GLB file is ") + format + " (" + extension + ")",
                    file_.where, "export it with PNG or JPEG textures");
    return corrupt("texture " + std::to_string(*index) + " of the GLB file has no image", file_.where);
  }
  const json* sampler = nth(file_.root, "samplers", whole(*texture, "sampler"));
  material.across = wrap_of(sampler, "wrapS");
  material.down = wrap_of(sampler, "wrapT");
  VACUFORM_TRY(found, image(*source));
  material.image = found;
  return {};
}

void GlbColours::note(std::string text) {
  if (std::find(notes_.begin(), notes_.end(), text) == notes_.end()) notes_.push_back(std::move(text));
}

Result<void> GlbColours::lay_emission(const json& given, bool black, ScanMaterial& material, Laid& laid) {
  Eigen::Vector3f light = Eigen::Vector3f::Zero();
  float strength = 1;
  if (const json* extensions = child(given, "extensions"))
    if (const json* stronger = child(*extensions, "KHR_materials_emissive_strength"))
      if (const auto it = stronger->find("emissiveStrength"); it != stronger->end()) {
        if (!it->is_number() || !std::isfinite(strength = it->get<float>()))
          return corrupt("a colour of the GLB file's materials is not of the documented form", file_.where);
      }
  if (!numbers(given, "emissiveFactor", 3, light.data()))
    return corrupt("a colour of the GLB file's materials is not of the documented form", file_.where);
  if (!(light.maxCoeff() > 0 && strength > 0)) return {};
  if (!black) {
    note(
        "Light that a material of the GLB file gives off (emissive) is ignored, because its base colour is "
        "not black");
    return {};
  }
  note("The base colour of a material of the GLB file is black, and its emissive colour is used");
  laid = {};
  material = {};
  material.factor = strength * light;
  if (const json* info = child(given, "emissiveTexture")) return lay_texture(*info, material, laid);
  return {};
}

Result<GlbColours::Laid> GlbColours::laid_material(std::optional<std::uint64_t> index) {
  if (!index) {
    if (!plain_) {
      plain_ = Laid{.material = static_cast<int>(colours_.materials.size())};
      colours_.materials.emplace_back();
    }
    return *plain_;
  }
  if (const auto it = materials_.find(*index); it != materials_.end()) return it->second;
  const json* given = nth(file_.root, "materials", index);
  if (!given) return corrupt("the GLB file has no material " + std::to_string(*index), file_.where);
  const json* model = child(*given, "pbrMetallicRoughness");
  const char *factor = "baseColorFactor", *texture = "baseColorTexture";
  if (const json* extensions = child(*given, "extensions"))
    if (const json* older = child(*extensions, "KHR_materials_pbrSpecularGlossiness"))
      model = older, factor = "diffuseFactor", texture = "diffuseTexture";
  ScanMaterial material;
  Laid laid;
  bool black = false;
  if (model) {
    if (!numbers(*model, factor, 3, material.factor.data()))
      return corrupt("a colour of the GLB file's materials is not of the documented form", file_.where);
    black = material.factor.maxCoeff() <= 0;
    const json* info = child(*model, texture);
    if (info && !black) VACUFORM_CHECK(lay_texture(*info, material, laid));
  }
  VACUFORM_CHECK(lay_emission(*given, black, material, laid));
  material.factor = material.factor.cwiseMax(0).cwiseMin(1);
  laid.material = static_cast<int>(colours_.materials.size());
  colours_.materials.push_back(material);
  return materials_[*index] = laid;
}

Result<void> GlbColours::add_uv(const GlbPrimitive& part, const Laid& laid, const TriangleMesh& mesh,
                                std::size_t first_vertex, std::size_t first_triangle) {
  const std::string name = "TEXCOORD_" + std::to_string(laid.set);
  if (!part.has(name))
    return corrupt("a primitive of the GLB file has a texture, but no " + name, file_.where);
  VACUFORM_TRY(given, part.attribute(name, "VEC2", 2));
  if (given.component == 5125 || given.count < mesh.vertices.size() - first_vertex)
    return corrupt(name + " of the GLB file does not fit its positions", file_.where);
  colours_.uv.resize(first_triangle);  // of the triangles without an image
  colours_.uv.reserve(mesh.triangles.size());
  for (std::size_t t = first_triangle; t < mesh.triangles.size(); ++t) {
    auto& corners = colours_.uv.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.triangles[t][k]) - first_vertex;
      corners[k] = laid.linear * Eigen::Vector2f(fraction(given, v, 0), fraction(given, v, 1)) + laid.shift;
      if (!(corners[k].cwiseAbs().maxCoeff() <= largest_uv))
        return corrupt("a texture coordinate of the GLB file is not a plausible number", file_.where);
    }
  }
  return {};
}

Result<void> GlbColours::add_vertex_colours(const GlbPrimitive& part, std::size_t first_vertex,
                                            std::size_t vertices) {
  const bool four = part.is("COLOR_0", "VEC4");
  VACUFORM_TRY(given, part.attribute("COLOR_0", four ? "VEC4" : "VEC3", four ? 4 : 3));
  if (given.component == 5125 || given.count < vertices - first_vertex)
    return corrupt("COLOR_0 of the GLB file does not fit its positions", file_.where);
  colours_.vertex.resize(first_vertex, Eigen::Vector3f::Ones());
  colours_.vertex.reserve(vertices);
  for (std::uint64_t i = 0; i < vertices - first_vertex; ++i) {
    Eigen::Vector3f colour;
    for (std::uint64_t k = 0; k < 3; ++k) {
      colour[static_cast<int>(k)] = fraction(given, i, k);
      if (!std::isfinite(colour[static_cast<int>(k)]))
        return corrupt("a vertex colour of the GLB file is not a finite number", file_.where);
    }
    colours_.vertex.push_back(colour.cwiseMax(0).cwiseMin(1));
  }
  return {};
}

Result<void> GlbColours::add(const GlbPrimitive& part, const json& primitive, const TriangleMesh& mesh,
                             std::size_t first_vertex, std::size_t first_triangle) {
  if (primitive.contains("material") && !whole(primitive, "material"))
    return corrupt("a primitive of the GLB file names no valid material", file_.where);
  VACUFORM_TRY(laid, laid_material(whole(primitive, "material")));
  colours_.material.resize(mesh.triangles.size(), laid.material);
  if (colours_.materials[laid.material].image >= 0)
    VACUFORM_CHECK(add_uv(part, laid, mesh, first_vertex, first_triangle));
  if (part.has("COLOR_0")) VACUFORM_CHECK(add_vertex_colours(part, first_vertex, mesh.vertices.size()));
  if (!colours_.uv.empty()) colours_.uv.resize(mesh.triangles.size());
  if (!colours_.vertex.empty()) colours_.vertex.resize(mesh.vertices.size(), Eigen::Vector3f::Ones());
  return {};
}

std::optional<ScanColours> GlbColours::take() {
  bool coloured = !colours_.images.empty() || !colours_.vertex.empty();
  for (const ScanMaterial& material : colours_.materials)
    coloured = coloured || material.factor != Eigen::Vector3f::Ones();
  return coloured ? std::optional(std::move(colours_)) : std::nullopt;
}

}  // namespace vacuform
