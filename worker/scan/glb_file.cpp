#include "worker/scan/glb_file.hpp"

namespace vacuform {

using nlohmann::json;

std::optional<std::uint64_t> whole(const json& object, const char* key, std::optional<std::uint64_t> absent) {
  const auto it = object.find(key);
  if (it == object.end()) return absent;
  if (it->is_number_unsigned() && it->get<std::uint64_t>() < std::uint64_t{1} << 53)
    return it->get<std::uint64_t>();
  return std::nullopt;
}

const json* nth(const json& root, const char* name, std::optional<std::uint64_t> n) {
  const auto it = root.find(name);
  if (!n || it == root.end() || !it->is_array() || *n >= it->size() || !(*it)[*n].is_object()) return nullptr;
  return &(*it)[*n];
}

const json* child(const json& object, const char* key) {
  const auto it = object.find(key);
  return it == object.end() || !it->is_object() ? nullptr : &*it;
}

Result<Bytes> GlbFile::bytes_of(const json& buffer_view, const std::string& what) const {
  const auto buffer = whole(buffer_view, "buffer"), start = whole(buffer_view, "byteOffset", 0),
             length = whole(buffer_view, "byteLength");
  const json* buffer_object = nth(root, "buffers", buffer);
  if (!buffer_object || !start || !length)
    return corrupt("the buffer view of " + what + " of the GLB file is not of the documented form", where);
  if (*buffer != 0 || buffer_object->contains("uri"))
    return fail(Code::unsupported_format,
                what + " of the GLB file lies outside of it (buffer " + std::to_string(*buffer) + ")", where,
                "export one self-contained GLB, or STL");
  if (*start + *length > binary.size())  // both are below 2^53
    return corrupt("the buffer view of " + what + " ends beyond the GLB file's binary chunk of " +
                       std::to_string(binary.size()) + " bytes",
                   where);
  return binary.subspan(*start, *length);
}

Result<GlbView> GlbFile::view(std::optional<std::uint64_t> index, const char* type,
                              std::uint64_t components) const {
  const std::string name = "accessor " + (index ? std::to_string(*index) : std::string("?"));
  const json* accessor = nth(root, "accessors", index);
  if (!accessor) return corrupt("the GLB file has no " + name, where);
  if (accessor->contains("sparse"))
    return fail(Code::unsupported_format, name + " of the GLB file is sparse", where,
                "export the scan as STL");
  if (accessor->value("type", json()) != type)
    return corrupt(name + " of the GLB file is not of type " + type, where);
  const auto count = whole(*accessor, "count"), offset = whole(*accessor, "byteOffset", 0),
             component = whole(*accessor, "componentType");
  if (!count || !offset || !component)
    return corrupt(name + " of the GLB file lacks its count or type", where);
  const std::uint64_t size = *component == 5121                         ? 1
                             : *component == 5123                       ? 2
                             : *component == 5125 || *component == 5126 ? 4
                                                                        : 0;
  if (size == 0)
    return fail(Code::unsupported_format,
                name + " of the GLB file has component type " + std::to_string(*component), where,
                "export the scan with float positions, or as STL");
  const json* buffer_view = nth(root, "bufferViews", whole(*accessor, "bufferView"));
  if (!buffer_view) return corrupt(name + " of the GLB file has no buffer view", where);
  const auto stride = whole(*buffer_view, "byteStride", size * components);
  if (!stride || *stride < size * components)
    return corrupt("the buffer view of " + name + " of the GLB file is not of the documented form", where);
  VACUFORM_TRY(bytes, bytes_of(*buffer_view, name));
  // Compares by division, so that nothing overflows.
  if (*count > 0 && (*offset > bytes.size() || bytes.size() - *offset < size * components ||
                     *count - 1 > (bytes.size() - *offset - size * components) / *stride))
    return corrupt(name + " of the GLB file has " + std::to_string(*count) +
                       " elements, more than its buffer view holds",
                   where);
  return GlbView{bytes.data() + *offset, *count, *stride, *component};
}

}  // namespace vacuform
