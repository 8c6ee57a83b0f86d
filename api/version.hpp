// The version of all programs, from CMakeLists.txt.
#pragma once

#include <string_view>

namespace vacuform {

inline constexpr std::string_view version = VACUFORM_VERSION;

}  // namespace vacuform
