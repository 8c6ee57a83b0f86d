// A parsed GLB file: its JSON and the bytes that the JSON describes, with every offset and count checked. Internal to
// worker/scan.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "worker/scan/scan_file.hpp"

namespace vacuform {

// Little-endian; all four bytes must exist.
inline std::uint32_t u32(Bytes bytes, std::uint64_t at) {
  return std::uint32_t{bytes[at]} | std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at + 2]} << 16 |
         std::uint32_t{bytes[at + 3]} << 24;
}

// The whole number under `key`, or `absent` if there is no such key; nullopt if it is something else or beyond 2^53.
std::optional<std::uint64_t> whole(const nlohmann::json& object, const char* key,
                                   std::optional<std::uint64_t> absent = {});

// The n-th object of the root's array `name`, or nullptr.
const nlohmann::json* nth(const nlohmann::json& root, const char* name, std::optional<std::uint64_t> n);

// The object under `key` of an object, or nullptr.
const nlohmann::json* child(const nlohmann::json& object, const char* key);

// Elements of an accessor and the stride between them, all inside of the BIN chunk.
struct GlbView {
  const std::uint8_t* data;
  std::uint64_t count, stride;
  std::uint64_t component;  // 5121: u8, 5123: u16, 5125: u32, 5126: float
};

// Keeps references to its parts.
struct GlbFile {
  const nlohmann::json& root;
  Bytes binary;
  const std::string& where;

  // Errors: corrupt_file, unsupported_format (sparse, or outside of the file).
  Result<GlbView> view(std::optional<std::uint64_t> accessor, const char* type,
                       std::uint64_t components) const;
  // The bytes of a buffer view; `what` names their content in messages. Errors: the same.
  Result<Bytes> bytes_of(const nlohmann::json& buffer_view, const std::string& what) const;
};

}  // namespace vacuform
