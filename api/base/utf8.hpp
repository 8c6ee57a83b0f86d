// UTF-8 text as code points, for texts that people type.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace vacuform {

// nullopt if the bytes are not UTF-8.
std::optional<std::u32string> code_points(std::string_view utf8);
std::string utf8(std::u32string_view points);

// The same text without the difference of upper and lower case. Bytes that are not UTF-8 become an empty text.
std::u32string folded(std::string_view utf8);

}  // namespace vacuform
