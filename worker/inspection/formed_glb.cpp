#include "worker/inspection/formed_glb.hpp"

#include <algorithm>
#include <cmath>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/version.hpp"
#include "worker/inspection/little_endian.hpp"
#include "worker/inspection/sheet_textures.hpp"
#include "worker/inspection/unfolded_sheet.hpp"
#include "worker/inspection/vertex_figures.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/vertex_normals.hpp"

namespace vacuform {

namespace {

using GltfJson = nlohmann::ordered_json;

// Numbers that the glTF specification assigns.
constexpr int of_floats = 5126, of_uint32 = 5125, for_vertices = 34962, for_indices = 34963;
constexpr int linear = 9729, linear_mipmaps = 9987, clamp_to_edge = 33071;
constexpr std::uint32_t json_chunk = 0x4e4f534a, binary_chunk = 0x004e4942;

// The binary part of the file and what describes it. Every view begins at a multiple of four bytes.
struct GltfBuffer {
  std::vector<std::uint8_t> bytes;
  GltfJson views = GltfJson::array(), accessors = GltfJson::array();

  // What was appended since `start` becomes a view.
  std::size_t add_view(std::size_t start, int target) {
    GltfJson view = {{"buffer", 0}, {"byteOffset", start}, {"byteLength", bytes.size() - start}};
    if (target != 0) view["target"] = target;
    views.push_back(std::move(view));
    bytes.resize((bytes.size() + 3) / 4 * 4, 0);
    return views.size() - 1;
  }

  // `size` numbers a vertex, from value(vertex, which); not finite ones become 0. Gives the number of the accessor.
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
    accessors.push_back({{"bufferView", add_view(start, for_vertices)},
                         {"componentType", of_floats},
                         {"count", count},
                         {"type", types[size - 1]},
                         {"min", least},
                         {"max", most}});
    return accessors.size() - 1;
  }

  std::size_t add_triangles(const std::vector<Triangle>& triangles) {
    const std::size_t start = bytes.size();
    bytes.reserve(start + 12 * triangles.size());
    for (const Triangle& t : triangles)
      for (const int v : t) append(bytes, static_cast<std::uint32_t>(v));
    accessors.push_back({{"bufferView", add_view(start, for_indices)},
                         {"componentType", of_uint32},
                         {"count", 3 * triangles.size()},
                         {"type", "SCALAR"}});
    return accessors.size() - 1;
  }

  GltfJson add_png(const char* name, const std::vector<std::uint8_t>& png) {
    const std::size_t start = bytes.size();
    bytes.insert(bytes.end(), png.begin(), png.end());
    return {{"name", name}, {"mimeType", "image/png"}, {"bufferView", add_view(start, 0)}};
  }
};

GltfJson attributes(const Finished& job, const Unfolded& all, GltfBuffer& buffer) {
  const FormedSheet& sheet = job.sheet;
  const std::size_t count = all.vertex.size();
  // Copies of a vertex differ in their pattern coordinates alone.
  const auto of_vertices = [&](std::size_t size, auto&& value) {
    return buffer.add_attribute(count, size, [&](std::size_t i, std::size_t k) {
      return value(static_cast<std::size_t>(all.vertex[i]), static_cast<Eigen::Index>(k));
    });
  };
  const auto of_values = [&](const std::vector<double>& values) {
    return of_vertices(1, [&](std::size_t v, Eigen::Index) { return values[v]; });
  };
  const std::vector<Eigen::Vector3d> normals = vertex_normals(sheet.formed, sheet.triangles);
  GltfJson out;
  out["POSITION"] = of_vertices(3, [&](std::size_t v, Eigen::Index k) { return sheet.formed[v][k]; });
  out["NORMAL"] = of_vertices(3, [&](std::size_t v, Eigen::Index k) { return normals[v][k]; });
  out["TEXCOORD_0"] = of_vertices(
      2, [&](std::size_t v, Eigen::Index k) { return texture_place(job.print, sheet.rest[v])[k]; });
  out["_SHEET"] = of_vertices(2, [&](std::size_t v, Eigen::Index k) { return sheet.rest[v][k]; });
  out["_PATTERN"] = buffer.add_attribute(
      count, 2, [&](std::size_t i, std::size_t k) { return all.uv[i][static_cast<Eigen::Index>(k)]; });
  out["_THICKNESS"] = of_values(sheet.thickness);
  out["_TEMPERATURE"] = of_values(sheet.temperature);
  out["_CONTACT"] =
      of_vertices(1, [&](std::size_t v, Eigen::Index) { return static_cast<double>(sheet.contact[v]); });
  const MoldDistance to_mold(job.mold.mesh);
  std::vector<double> gaps(sheet.formed.size(), 0);
  in_parallel(0, static_cast<int>(gaps.size()), [&](int first, int last) {
    for (auto v = static_cast<std::size_t>(first); v < static_cast<std::size_t>(last); ++v)
      if (sheet.contact[v] != Contact::mold) gaps[v] = to_mold(sheet.formed[v]);
  });
  out["_GAP"] = of_values(gaps);
  out["_SHAPE"] = of_values(anisotropy_of_vertices(job));
  out["_AREA"] = of_values(area_ratio_of_vertices(job));
  out["_CHART"] = buffer.add_attribute(
      count, 1, [&](std::size_t i, std::size_t) { return all.uv[i].hasNaN() ? 0.0 : 1.0; });
  return out;
}

GltfJson material(const char* name, int texture) {
  return {{"name", name},
          {"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorTexture", {{"index", texture}}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.5}}}};
}

// The header and the two chunks; each chunk is a multiple of four bytes long.
std::vector<std::uint8_t> glb_of(std::string json, const std::vector<std::uint8_t>& binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::vector<std::uint8_t> out{'g', 'l', 'T', 'F'};
  out.reserve(28 + json.size() + binary.size());
  append(out, std::uint32_t{2});
  append(out, static_cast<std::uint32_t>(28 + json.size() + binary.size()));
  append(out, static_cast<std::uint32_t>(json.size()));
  append(out, json_chunk);
  out.insert(out.end(), json.begin(), json.end());
  append(out, static_cast<std::uint32_t>(binary.size()));
  append(out, binary_chunk);
  out.insert(out.end(), binary.begin(), binary.end());
  return out;
}

}  // namespace

Result<std::vector<std::uint8_t>> formed_glb(const Finished& job, const Context& context) {
  constexpr const char *with = "pre-distorted", *without = "printed as drawn";
  std::optional<SheetPicture> picture;
  if (over_colours(job)) picture.emplace(job);
  const SheetPicture* const over = picture ? &*picture : nullptr;
  // Beside the other one, or after it where no thread is to be had.
  auto printed = std::async([&] { return print_texture(job, over); });
  VACUFORM_TRY(drawn, drawing_texture(job, over, context));
  const Unfolded all = unfolded(job);
  GltfBuffer buffer;
  GltfJson primitive;
  primitive["attributes"] = attributes(job, all, buffer);
  primitive["indices"] = buffer.add_triangles(all.corners);
  primitive["material"] = 0;
  const auto shown_by = [](int variant) {
    return GltfJson{{"material", variant}, {"variants", GltfJson::array({variant})}};
  };
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = GltfJson::array({shown_by(0), shown_by(1)});
  const GltfJson images =
      GltfJson::array({buffer.add_png(with, printed.get()), buffer.add_png(without, drawn)});
  const auto texture = [](int image) { return GltfJson{{"sampler", 0}, {"source", image}}; };

  GltfJson all_of_it = {
      {"asset",
       {{"version", "2.0"},
        {"generator", "Vacuform " + std::string(version)},
        {"extras",
         {{"frame",
           "vertices: mm, z up, platform at z = 0, centre of the sheet at x = y = 0; node: metres, y up"},
          {"label", job.label}}}}},
      {"extensionsUsed", GltfJson::array({"KHR_materials_variants"})},
      {"extensions",
       {{"KHR_materials_variants",
         {{"variants", GltfJson::array({GltfJson{{"name", with}}, GltfJson{{"name", without}}})}}}}},
      {"scene", 0},
      {"scenes", GltfJson::array({GltfJson{{"nodes", GltfJson::array({0})}}})}};
  // By columns: (x, y, z) in mm to (x, z, -y) in metres.
  GltfJson node = {{"name", "formed sheet"}, {"mesh", 0}};
  node["matrix"] = {0.001, 0.0, 0.0, 0.0, 0.0, 0.0, -0.001, 0.0, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
  all_of_it["nodes"] = GltfJson::array({node});
  all_of_it["meshes"] = GltfJson::array({GltfJson{{"primitives", GltfJson::array({primitive})}}});
  all_of_it["materials"] = GltfJson::array({material(with, 0), material(without, 1)});
  all_of_it["textures"] = GltfJson::array({texture(0), texture(1)});
  all_of_it["images"] = images;
  all_of_it["samplers"] = GltfJson::array({GltfJson{{"magFilter", linear},
                                                    {"minFilter", linear_mipmaps},
                                                    {"wrapS", clamp_to_edge},
                                                    {"wrapT", clamp_to_edge}}});
  all_of_it["accessors"] = std::move(buffer.accessors);
  all_of_it["bufferViews"] = std::move(buffer.views);
  all_of_it["buffers"] = GltfJson::array({GltfJson{{"byteLength", buffer.bytes.size()}}});
  return glb_of(all_of_it.dump(), buffer.bytes);
}

}  // namespace vacuform
