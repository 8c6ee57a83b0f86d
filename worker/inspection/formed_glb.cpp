#include "worker/inspection/formed_glb.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/version.hpp"
#include "worker/gltf/gltf_buffer.hpp"
#include "worker/inspection/heat_maps.hpp"
#include "worker/inspection/sheet_textures.hpp"
#include "worker/inspection/unfolded_sheet.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/vertex_normals.hpp"

namespace vacuform {

namespace {

GltfJson attributes(const Finished& job, const Unfolded& all, const std::vector<HeatMap>& maps,
                    GltfBuffer& buffer) {
  const FormedSheet& sheet = job.sheet;
  const std::size_t count = all.vertex.size();
  // Copies of a vertex differ only in their pattern coordinates.
  const auto of_vertices = [&](std::size_t size, auto&& value) {
    return buffer.add_attribute(count, size, [&](std::size_t i, std::size_t k) {
      return value(static_cast<std::size_t>(all.vertex[i]), static_cast<Eigen::Index>(k));
    });
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
  out["_CONTACT"] =
      of_vertices(1, [&](std::size_t v, Eigen::Index) { return static_cast<double>(sheet.contact[v]); });
  for (const HeatMap& map : maps) {  // -1: no value
    std::string name = "_";
    for (const char c : map.id) name += static_cast<char>(c - 'a' + 'A');
    out[name] = of_vertices(
        1, [&](std::size_t v, Eigen::Index) { return std::isnan(map.values[v]) ? -1 : map.values[v]; });
  }
  out["_CHART"] = buffer.add_attribute(
      count, 1, [&](std::size_t i, std::size_t) { return all.uv[i].hasNaN() ? 0.0 : 1.0; });
  return out;
}

// Whether the formed part shows what print.png shows: nothing lies below it, and no ink in it makes up for the stretch.
bool looks_as_printed(const Print& print) {
  const PrintedColours* const colours = print.main().source->colours();
  return print.layers.size() == 1 && !(colours && colours->ink);
}

GltfJson material(const char* name, int texture) {
  return {{"name", name},
          {"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorTexture", {{"index", texture}}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.5}}}};
}

}  // namespace

Result<std::vector<std::uint8_t>> formed_glb(const Finished& job, const SheetPicture& print,
                                             const Context& context) {
  constexpr const char *with = "pre-distorted", *without = "printed as drawn";
  const SheetPicture* const over = looks_as_printed(job.print) ? nullptr : &print;
  const Unfolded all = textured(job);
  const std::vector<HeatMap> maps = heat_maps(job);
  GltfBuffer buffer;
  GltfJson primitive;
  std::vector<std::uint8_t> printed;
  Result<std::vector<std::uint8_t>> drawing;
  together([&] { printed = print_texture(job, over); },
           [&] { drawing = drawing_texture(job, over, context); },
           [&] { primitive["attributes"] = attributes(job, all, maps, buffer); });
  VACUFORM_TRY(drawn, std::move(drawing));
  primitive["indices"] = buffer.add_triangles(all.corners);
  primitive["material"] = 0;
  const auto shown_by = [](int variant) {
    return GltfJson{{"material", variant}, {"variants", GltfJson::array({variant})}};
  };
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = GltfJson::array({shown_by(0), shown_by(1)});
  const GltfJson images = GltfJson::array({buffer.add_png(with, printed), buffer.add_png(without, drawn)});
  const auto texture = [](int image) { return GltfJson{{"sampler", 0}, {"source", image}}; };

  GltfJson all_of_it = {
      {"asset",
       {{"version", "2.0"},
        {"generator", "Vacuform " + std::string(version)},
        {"extras",
         {{"frame",
           "vertices: mm, z up, platform at z = 0, centre of the sheet at x = y = 0; node: metres, y up"},
          {"label", job.label},
          {"maps", heat_maps_json(maps)}}}}},
      {"extensionsUsed", GltfJson::array({"KHR_materials_variants"})},
      {"extensions",
       {{"KHR_materials_variants",
         {{"variants", GltfJson::array({GltfJson{{"name", with}}, GltfJson{{"name", without}}})}}}}},
      {"scene", 0},
      {"scenes", GltfJson::array({GltfJson{{"nodes", GltfJson::array({0})}}})}};
  GltfJson node = {{"name", "formed sheet"}, {"mesh", 0}};
  node["matrix"] = gltf_matrix_from_mm();
  all_of_it["nodes"] = GltfJson::array({node});
  all_of_it["meshes"] = GltfJson::array({GltfJson{{"primitives", GltfJson::array({primitive})}}});
  all_of_it["materials"] = GltfJson::array({material(with, 0), material(without, 1)});
  all_of_it["textures"] = GltfJson::array({texture(0), texture(1)});
  all_of_it["images"] = images;
  all_of_it["samplers"] = GltfJson::array({GltfJson{{"magFilter", gltf::linear},
                                                    {"minFilter", gltf::linear_mipmaps},
                                                    {"wrapS", gltf::clamp_to_edge},
                                                    {"wrapT", gltf::clamp_to_edge}}});
  return glb_of(std::move(all_of_it), std::move(buffer));
}

}  // namespace vacuform
