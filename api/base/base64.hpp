// Base 64 (RFC 4648, 4), in constant time.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace vacuform {

std::string to_base64(std::string_view bytes);
// Nothing if the text is not padded base 64, in which characters of `ignored` may stand.
std::optional<std::string> from_base64(std::string_view text, const char* ignored = nullptr);

}  // namespace vacuform
