// What a drawing is by its first bytes, and an SVG as the text that its readers take. Internal to worker/pattern.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "api/base/error.hpp"

namespace vacuform {

enum class DrawingFormat { png, jpeg, svg, dxf, other };

// Packed SVG (SVGZ) and SVG in UTF-16 are svg.
DrawingFormat drawing_format(std::span<const std::uint8_t> bytes);

// The error of a drawing that is `other`: it names the format if that is known, and the way to one that is read.
tl::unexpected<Error> unread_format(std::span<const std::uint8_t> bytes, const std::string& file_name);

// Unpacked, in UTF-8, and with entities replaced by what they stand for. Errors: corrupt_file, too_large, and
// unsupported_format (packed, but not SVG).
Result<std::string> svg_text(std::span<const std::uint8_t> bytes, const std::string& file_name);

}  // namespace vacuform
