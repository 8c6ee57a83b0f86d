// What a file seems to be, by its first bytes, its length and its name's extension: as much as the server may look at.
// Parsing is for the sandboxed child of a worker, which may still refuse what passes here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

inline constexpr std::size_t format_head = 512;  // bytes that are looked at

// "stl", "obj", "ply", "off", "glb", "zip", "svg", "dxf", "png", "jpeg", "csv" or "icc". `head` holds the first bytes of the file,
// format_head of them or all; `input` is a name of input_kinds. Errors: unsupported_format.
Result<std::string_view> format_of(std::string_view input, std::string_view head, std::uint64_t bytes,
                                   std::string_view extension);

}  // namespace vacuform
