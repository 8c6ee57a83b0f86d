// A primitive of a GLB file: its attributes and indices, from accessors or compressed by Draco (KHR_draco_mesh_compression,
// bitstream 2.2). Internal to worker/scan.
#pragma once

#include <map>
#include <vector>

#include "worker/scan/glb_file.hpp"

namespace vacuform {

class GlbPrimitive {
 public:
  // `primitive` is an object with an object "attributes". Keeps references to both; decodes what is compressed, unless the
  // accessors have the same data. Errors: corrupt_file, unsupported_format, too_large.
  static Result<GlbPrimitive> read(const GlbFile& file, const nlohmann::json& primitive);

  bool compressed() const { return !decoded_.empty(); }
  bool has(const std::string& attribute) const { return attributes_.contains(attribute); }
  // Whether the accessor of an attribute has that type, such as VEC3.
  bool is(const std::string& attribute, const char* type) const;
  // Views into this object or into the file. Errors: as GlbFile::view().
  Result<GlbView> attribute(const std::string& name, const char* type, std::uint64_t components) const;
  // The corners of the triangles; nothing if they are the vertices in their order. Compressed ones are three for each
  // triangle, whatever the mode of the primitive.
  Result<std::optional<GlbView>> indices() const;

 private:
  struct Decoded {
    std::vector<float> values;
    std::uint64_t components = 0;
  };
  GlbPrimitive(const GlbFile& file, const nlohmann::json& primitive)
      : file_(file), primitive_(primitive), attributes_(primitive["attributes"]) {}
  Result<void> decode(const nlohmann::json& extension);

  const GlbFile& file_;
  const nlohmann::json &primitive_, &attributes_;
  std::map<std::string, Decoded> decoded_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace vacuform
