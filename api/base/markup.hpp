// Text in markup: SVG, HTML.
#pragma once

#include <string>
#include <string_view>

namespace vacuform {

// & < > " ' as entities; control characters, and bytes that are no UTF-8, become '?', a tab or a new line a space.
std::string escaped(std::string_view text);

}  // namespace vacuform
