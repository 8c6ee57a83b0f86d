#include "worker/scan/glb_primitive.hpp"

#include <draco/compression/decode.h>

#include <memory>
#include <new>

namespace vacuform {

using nlohmann::json;

namespace {

// Bytes of a Draco bitstream, one after the other. Past the end they are 0.
class DracoBytes {
 public:
  explicit DracoBytes(Bytes bytes) : bytes_(bytes) {}
  std::uint8_t next() { return at_ < bytes_.size() ? bytes_[at_++] : std::uint8_t{0}; }
  // LEB128, of at most 32 bits.
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const std::uint8_t byte = next();
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if (byte < 0x80) break;
    }
    return value;
  }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

// Checks what the bitstream says of itself, because the decoder makes room for it before it has read more.
Result<void> check_header(Bytes bytes, const std::string& where) {
  if (bytes.size() < 11 || std::string_view(reinterpret_cast<const char*>(bytes.data()), 5) != "DRACO")
    return corrupt("a compressed primitive of the GLB file does not begin as Draco does", where);
  DracoBytes header(bytes.subspan(5));
  const int major = header.next(), minor = header.next(), kind = header.next(), method = header.next();
  const int flags = header.next() | header.next() << 8;
  if (major != 2 || minor != 2 || kind != 1 || method > 1)
    return fail(Code::unsupported_format,
                "a compressed primitive of the GLB file is not a Draco mesh of version 2.2", where,
                "export it without compression");
  if (flags & 0x8000)  // free text, which may name people
    return fail(Code::unsupported_format, "a compressed primitive of the GLB file carries metadata", where,
                "export it without compression");
  if (method == 1) header.next();  // how the connectivity is traversed
  const std::uint64_t first = header.number(), second = header.number();
  const std::uint64_t triangles = method == 1 ? second : first, vertices = method == 1 ? first : second;
  if (triangles > scan_limits.triangles) return too_many_triangles(triangles, where);
  if (vertices > 3 * triangles)
    return corrupt("a compressed primitive of the GLB file has more vertices than its triangles have corners",
                   where);
  return {};
}

float largest(draco::DataType type) {
  switch (type) {
    case draco::DT_UINT8:
      return 255;
    case draco::DT_UINT16:
      return 65535;
    default:
      return 1;
  }
}

}  // namespace

Result<GlbPrimitive> GlbPrimitive::read(const GlbFile& file, const json& primitive) {
  GlbPrimitive read(file, primitive);
  const json* extensions = child(primitive, "extensions");
  const json* extension = extensions ? child(*extensions, "KHR_draco_mesh_compression") : nullptr;
  const json* positions = nth(file.root, "accessors", whole(read.attributes_, "POSITION"));
  if (extension && positions && !positions->contains("bufferView")) VACUFORM_CHECK(read.decode(*extension));
  return read;
}

Result<void> GlbPrimitive::decode(const json& extension) {
  const json* view = nth(file_.root, "bufferViews", whole(extension, "bufferView"));
  const json* ids = child(extension, "attributes");
  if (!view || !ids || !ids->contains("POSITION"))
    return corrupt("a compressed primitive of the GLB file lacks its buffer view or its positions",
                   file_.where);
  VACUFORM_TRY(bytes, file_.bytes_of(*view, "a compressed primitive"));
  VACUFORM_CHECK(check_header(bytes, file_.where));
  const auto broken = [&] {
    return corrupt("a compressed primitive of the GLB file cannot be decompressed", file_.where);
  };
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::unique_ptr<draco::Mesh> mesh;
  try {
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return broken();
    mesh = std::move(decoded).value();
  } catch (const std::bad_alloc&) {
    return fail(Code::too_large, "a compressed primitive of the GLB file needs too much memory", file_.where,
                "reduce the scan (quadric decimation), or export it without compression");
  }
  const std::uint64_t points = mesh->num_points();
  for (const auto& [name, id] : ids->items()) {
    if (!id.is_number_unsigned() || id.get<std::uint64_t>() > UINT32_MAX) return broken();
    const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(id.get<std::uint32_t>());
    const int components = attribute ? attribute->num_components() : 0;
    if (components < 1 || components > 4) {
      if (name != "POSITION" && name != "COLOR_0" && name.rfind("TEXCOORD_", 0) != 0) continue;
      return broken();
    }
    Decoded& decoded = decoded_[name];
    decoded.components = static_cast<std::uint64_t>(components);
    decoded.values.resize(points * decoded.components);
    const float scale =
        attribute->normalized() || name.starts_with("JOINTS_") ? 1 : 1 / largest(attribute->data_type());
    for (std::uint32_t i = 0; i < points; ++i) {
      float* const values = decoded.values.data() + i * decoded.components;
      const auto value = attribute->mapped_index(draco::PointIndex(i));
      if (value.value() >= attribute->size() ||
          !attribute->ConvertValue<float>(value, static_cast<std::int8_t>(components), values))
        return broken();
      for (int k = 0; k < components; ++k) values[k] *= scale;
    }
  }
  corners_.reserve(3 * std::size_t{mesh->num_faces()});
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f)
    for (const auto& corner : mesh->face(draco::FaceIndex(f))) corners_.push_back(corner.value());
  return {};
}

bool GlbPrimitive::is(const std::string& attribute, const char* type) const {
  const json* accessor = nth(file_.root, "accessors", whole(attributes_, attribute.c_str()));
  return accessor && accessor->value("type", json()) == type;
}

Result<GlbView> GlbPrimitive::attribute(const std::string& name, const char* type,
                                        std::uint64_t components) const {
  const auto it = decoded_.find(name);
  if (it == decoded_.end()) return file_.view(whole(attributes_, name.c_str()), type, components);
  const auto& [values, given] = it->second;
  if (given < components) return corrupt(name + " of the GLB file is not of type " + type, file_.where);
  return GlbView{reinterpret_cast<const std::uint8_t*>(values.data()), values.size() / given, 4 * given,
                 5126};
}

Result<std::optional<GlbView>> GlbPrimitive::indices() const {
  if (compressed())
    return std::optional(
        GlbView{reinterpret_cast<const std::uint8_t*>(corners_.data()), corners_.size(), 4, 5125});
  if (!primitive_.contains("indices")) return std::optional<GlbView>();
  VACUFORM_TRY(given, file_.view(whole(primitive_, "indices"), "SCALAR", 1));
  if (given.component == 5126) return corrupt("the indices of the GLB file are floats", file_.where);
  return std::optional(given);
}

}  // namespace vacuform
