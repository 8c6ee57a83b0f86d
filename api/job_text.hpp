// What a person writes about a job: the same limits for every program.
#pragma once

#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

inline constexpr std::size_t longest_reference = 64, longest_note = 500;  // characters
inline constexpr std::string_view reference_hint = "Order or case number. Do not type a name.";
inline constexpr std::string_view note_hint =
    "A remark for the people who work with the job. Do not type a name.";

// The reference (the order or case number of a job) without the blanks around it: one line of printable characters.
// Errors: bad_usage, which never repeats the text.
Result<std::string> clean_reference(std::string_view text);
// The note of a job without the blanks around it. Its lines end with '\n'; it has no other control characters. Errors:
// as above.
Result<std::string> clean_note(std::string_view text);

}  // namespace vacuform
