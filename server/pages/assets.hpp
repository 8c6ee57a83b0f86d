// Files of the source tree that are built into the program (see embed.cmake).
#pragma once

#include <string_view>

namespace vacuform {

std::string_view openapi_yaml();
std::string_view style_css();
std::string_view job_js();

}  // namespace vacuform
