// UTF-8 text as code points, for texts that people type.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace vacuform {

// nullopt if the bytes are not UTF-8.
std::optional<std::u32string> code_points(std::string_view utf8);
std::string utf8(std::u32string_view points);

// The text as it can be shown in a terminal or a page: what would act there instead of being seen is written out. That are
// control characters (\x1b), marks that turn the direction of the text or break the line (\u202e), and bytes that are no
// UTF-8 (\xff).
std::string printable(std::string_view text);

// The same text without the difference of upper and lower case. Bytes that are not UTF-8 become an empty text.
std::u32string folded(std::string_view utf8);

}  // namespace vacuform
