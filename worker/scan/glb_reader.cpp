// GLB, the binary container of glTF 2.0 (ISO/IEC 12113): the meshes of every node of the scene, in world coordinates, with
// morph targets, skins and instances applied (glb_pose.hpp).
// Positions are floats, or compressed by Draco. Data outside the file, sparse accessors and other required extensions that
// change the geometry (meshopt, quantization) are rejected by name.
#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "worker/scan/glb_colours.hpp"
#include "worker/scan/glb_pose.hpp"
#include "worker/scan/glb_primitive.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

constexpr std::uint32_t most_json_bytes = 16u << 20;  // parsed, it needs up to twenty times its bytes

struct Reader {
  const GlbFile& file;
  const ScanProgress& progress;
  GlbColours* colours;  // null: only the shape is read
  ScanFile scan;
  const json& root = file.root;
  const std::string& where = file.where;

  GlbPose pose{file};

  // The mesh of a node, at all places of the node.
  Result<void> primitive(const json& p, const json& mesh, const json& node,
                         const std::vector<Eigen::Affine3d>& places) {
    const auto mode = whole(p, "mode", 4);
    if (!mode || *mode > 6) return corrupt("a primitive of the GLB file has no known mode", where);
    if (*mode < 4) return {};  // points and lines are not a surface
    const auto attributes = p.find("attributes");
    if (attributes == p.end() || !attributes->is_object())
      return corrupt("a primitive of the GLB file has no attributes", where);
    VACUFORM_TRY(part, GlbPrimitive::read(file, p));
    VACUFORM_TRY(positions, part.attribute("POSITION", "VEC3", 3));
    if (positions.component != 5126)
      return fail(Code::unsupported_format, "the positions of the GLB file are not floats", where,
                  "export the scan without quantization, or as STL");
    auto& [vertices, triangles] = scan.mesh;
    if (vertices.size() + positions.count * places.size() > scan_limits.vertices)
      return fail(Code::too_large,
                  "the scan has more than " + std::to_string(scan_limits.vertices) + " vertices", where,
                  "reduce it (quadric decimation) to a few hundred thousand triangles");
    VACUFORM_TRY(indices, part.indices());
    const std::uint64_t n = indices ? indices->count : positions.count, shape = part.compressed() ? 4 : *mode;
    const std::uint64_t added = shape == 4 ? n / 3 : n < 3 ? 0 : n - 2;
    if (triangles.size() + added * places.size() > scan_limits.triangles)
      return too_many_triangles(triangles.size() + added * places.size(), where);

    std::vector<Eigen::Vector3d> points;
    points.reserve(positions.count);
    for (std::uint64_t i = 0; i < positions.count; ++i) {
      const Bytes element(positions.data + i * positions.stride, 12);
      points.emplace_back(std::bit_cast<float>(u32(element, 0)), std::bit_cast<float>(u32(element, 4)),
                          std::bit_cast<float>(u32(element, 8)));
    }
    VACUFORM_CHECK(pose.morph(node, mesh, p, part, points));
    std::optional<bool> mirrored;
    if (node.contains("skin")) {
      const auto skin = whole(node, "skin");
      if (!skin) return corrupt("a node of the GLB file names no valid skin", where);
      VACUFORM_TRY(turned, pose.skin(*skin, part, points));
      mirrored = turned;
    }
    for (const Eigen::Affine3d& place : places) {
      VACUFORM_CHECK(progress.tick());
      const std::size_t base = vertices.size(), first = triangles.size();
      for (const Eigen::Vector3d& point : points) vertices.push_back(mirrored ? point : place * point);
      bool beyond = false;
      const auto corner = [&](std::uint64_t i) {
        std::uint64_t index = i;
        if (indices) {
          const std::uint8_t* at = indices->data + i * indices->stride;
          index = indices->component == 5121   ? at[0]
                  : indices->component == 5123 ? std::uint64_t{at[0]} | std::uint64_t{at[1]} << 8
                                               : u32(Bytes(at, 4), 0);
        }
        if (index >= positions.count) return beyond = true, 0;
        return static_cast<int>(base + index);
      };
      const bool turned = mirrored.value_or(place.linear().determinant() < 0);
      for (std::uint64_t i = 0; i < added && !beyond; ++i) {
        Triangle t = shape == 4   ? Triangle{corner(3 * i), corner(3 * i + 1), corner(3 * i + 2)}
                     : shape == 5 ? Triangle{corner(i), corner(i + 1 + i % 2), corner(i + 2 - i % 2)}
                                  : Triangle{corner(0), corner(i + 1), corner(i + 2)};
        if (turned) std::swap(t[1], t[2]);
        triangles.push_back(t);
      }
      if (beyond)
        return corrupt("a triangle of the GLB file names a vertex beyond the " +
                           std::to_string(positions.count) + " of its mesh",
                       where);
      if (colours) VACUFORM_CHECK(colours->add(part, p, scan.mesh, base, first));
    }
    return {};
  }

  static std::optional<Eigen::Affine3d> local_transform(const json& node) {
    const auto numbers = [&](const char* key,
                             std::vector<double> absent) -> std::optional<std::vector<double>> {
      const auto it = node.find(key);
      if (it == node.end()) return absent;
      if (!it->is_array() || it->size() != absent.size()) return std::nullopt;
      for (std::size_t i = 0; i < absent.size(); ++i) {
        if (!(*it)[i].is_number()) return std::nullopt;
        absent[i] = (*it)[i].get<double>();
        if (!std::isfinite(absent[i])) return std::nullopt;
      }
      return absent;
    };
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (node.contains("matrix")) {
      const auto m = numbers("matrix", std::vector<double>(16, 0.0));
      if (!m) return std::nullopt;
      for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
          transform(row, column) = (*m)[4 * static_cast<std::size_t>(column) + static_cast<std::size_t>(row)];
      return transform;
    }
    const auto t = numbers("translation", {0, 0, 0}), r = numbers("rotation", {0, 0, 0, 1}),
               s = numbers("scale", {1, 1, 1});
    if (!t || !r || !s) return std::nullopt;
    const Eigen::Quaterniond q((*r)[3], (*r)[0], (*r)[1], (*r)[2]);
    if (!(q.norm() > 1e-6)) return std::nullopt;
    transform.translate(Eigen::Vector3d((*t)[0], (*t)[1], (*t)[2]));
    transform.rotate(q.normalized());
    transform.scale(Eigen::Vector3d((*s)[0], (*s)[1], (*s)[2]));
    return transform;
  }

  // Walks the nodes without recursion: a chain of a million nodes must not use up the stack.
  Result<void> nodes() {
    const auto list = root.find("nodes");
    if (list == root.end() || !list->is_array()) return corrupt("the GLB file has no nodes", where);
    std::vector<char> state(list->size(), 0);  // 1: child of another node, or a root already visited
    std::vector<std::pair<std::uint64_t, Eigen::Affine3d>> open;
    const auto push = [&](const json& children, const Eigen::Affine3d& transform) {
      if (!children.is_array()) return false;
      for (auto child = children.rbegin(); child != children.rend(); ++child) {
        if (!child->is_number_unsigned() || child->get<std::uint64_t>() >= state.size()) return false;
        const auto index = child->get<std::uint64_t>();
        if (state[index]++) return false;  // a node with two parents, or a cycle
        open.emplace_back(index, transform);
      }
      return true;
    };
    const json* scene = nth(root, "scenes", whole(root, "scene", 0));
    bool sound = true;
    if (scene && scene->contains("nodes")) {
      sound = push((*scene)["nodes"], Eigen::Affine3d::Identity());
    } else {  // no scene: every node that is not a child is a root
      std::vector<char> is_child(list->size(), 0);
      for (const auto& node : *list)
        if (node.is_object() && node.contains("children") && node["children"].is_array())
          for (const auto& child : node["children"])
            if (child.is_number_unsigned() && child.get<std::uint64_t>() < is_child.size())
              is_child[child.get<std::uint64_t>()] = 1;
      json roots = json::array();
      for (std::size_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) roots.push_back(i);
      sound = push(roots, Eigen::Affine3d::Identity());
    }
    std::vector<std::pair<std::uint64_t, Eigen::Affine3d>> with_mesh;
    while (sound && !open.empty()) {
      VACUFORM_CHECK(progress.tick());
      const auto [index, parent] = open.back();
      open.pop_back();
      const json* node = nth(root, "nodes", index);
      if (!node) return corrupt("node " + std::to_string(index) + " of the GLB file is not an object", where);
      const auto local = local_transform(*node);
      if (!local)
        return corrupt("node " + std::to_string(index) + " of the GLB file has no valid transform", where);
      const Eigen::Affine3d transform = parent * *local;
      pose.set_world(index, transform);
      if (node->contains("children")) sound = push((*node)["children"], transform);
      if (node->contains("mesh")) with_mesh.emplace_back(index, transform);
    }
    if (!sound) return corrupt("the nodes of the GLB file do not form a tree", where);
    // Afterwards, because a skin needs all of its joints.
    for (const auto& [index, transform] : with_mesh) {
      VACUFORM_CHECK(progress.tick());
      const json& node = *nth(root, "nodes", index);
      const json* mesh = nth(root, "meshes", whole(node, "mesh"));
      if (!mesh || !mesh->contains("primitives") || !(*mesh)["primitives"].is_array())
        return corrupt("node " + std::to_string(index) + " of the GLB file names a mesh that is not there",
                       where);
      VACUFORM_TRY(places, pose.places(node, transform));
      for (const auto& p : (*mesh)["primitives"]) {
        if (!p.is_object()) return corrupt("a primitive of the GLB file is not an object", where);
        VACUFORM_CHECK(primitive(p, *mesh, node, places));
      }
    }
    return {};
  }
};

// Extensions that are read, or leave the triangles where they are.
bool known(std::string_view extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
         extension.starts_with("EXT_texture_") || extension == "KHR_lights_punctual" ||
         extension == "KHR_xmp_json_ld" || extension == "KHR_draco_mesh_compression" ||
         extension == "EXT_mesh_gpu_instancing";
}

}  // namespace

Result<ScanFile> read_glb(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts) {
  const auto damaged = [&](const std::string& otherwise) {
    const std::string damage = text_mode_damage(bytes);
    return corrupt(damage.empty() ? otherwise : damage, where);
  };
  if (bytes.size() < 20) return damaged("the GLB file ends within its header of 20 bytes");
  const std::uint32_t version = u32(bytes, 4), length = u32(bytes, 8), json_bytes = u32(bytes, 12);
  if (version != 2)
    return fail(Code::unsupported_format, "a GLB file of version " + std::to_string(version), where,
                "export glTF 2.0, or STL");
  if (length > bytes.size() || u32(bytes, 16) != 0x4E4F534A || json_bytes > bytes.size() - 20)
    return damaged("the GLB file says it has " + std::to_string(length) + " bytes, but it has " +
                   std::to_string(bytes.size()));
  if (json_bytes > most_json_bytes)
    return fail(Code::too_large,
                "the JSON chunk of the GLB file has " + std::to_string(json_bytes) +
                    " bytes, above the limit of 16 MiB",
                where, "export the mesh alone, without scenery, or as STL");
  constexpr int deepest = 64;
  const auto shallow = [](int depth, json::parse_event_t, json&) { return depth <= deepest; };
  const json root = json::parse(bytes.begin() + 20, bytes.begin() + 20 + json_bytes, shallow, false);
  if (!root.is_object()) return damaged("the JSON chunk of the GLB file is not valid");

  if (const auto required = root.find("extensionsRequired"); required != root.end()) {
    if (!required->is_array()) return corrupt("extensionsRequired of the GLB file is not a list", where);
    for (const auto& extension : *required) {
      if (!extension.is_string())
        return corrupt("extensionsRequired of the GLB file has entries that are not names", where);
      const auto& name = extension.get_ref<const std::string&>();
      if (!known(name))
        return fail(Code::unsupported_format,
                    "the GLB file requires the extension " + name.substr(0, 80) + ", which is not read",
                    where, "export it without compression, or as STL");
    }
  }
  Bytes binary;
  const std::uint64_t chunk = 20 + (std::uint64_t{json_bytes} + 3) / 4 * 4;
  if (chunk + 8 <= bytes.size()) {
    const std::uint32_t size = u32(bytes, chunk);
    if (u32(bytes, chunk + 4) != 0x004E4942 || size > bytes.size() - chunk - 8)
      return damaged("the binary chunk of the GLB file is not where its header says");
    binary = bytes.subspan(chunk + 8, size);
  }
  const GlbFile file{root, binary, where};
  GlbColours colours(file);
  Reader reader{file, progress, parts == ScanParts::with_colours ? &colours : nullptr, {}};
  reader.scan.format = "GLB";
  reader.scan.y_up = true;
  if (auto walked = reader.nodes(); !walked) {
    if (walked.error().code == Code::corrupt_file) return damaged(walked.error().what);
    return tl::make_unexpected(walked.error());
  }
  if (reader.colours) {
    reader.scan.colour_notes = colours.notes();
    reader.scan.colours = colours.take();
  }
  return std::move(reader.scan);
}

}  // namespace vacuform
