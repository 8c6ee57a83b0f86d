#include "api/base/markup.hpp"

#include <algorithm>

namespace vacuform {

namespace {

// Length of the UTF-8 sequence that begins the text, 0 where none does.
std::size_t sequence(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80                                ? 1
                             : (byte(0) & 0xe0) == 0xc0 && byte(0) >= 0xc2 ? 2
                             : (byte(0) & 0xf0) == 0xe0                    ? 3
                             : (byte(0) & 0xf8) == 0xf0 && byte(0) <= 0xf4 ? 4
                                                                           : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return length;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = sequence(text);
    const std::string_view taken = text.substr(0, std::max<std::size_t>(1, length));
    text.remove_prefix(taken.size());
    if (length == 0 || (length == 1 && (static_cast<unsigned char>(taken[0]) < 0x20 || taken[0] == 0x7f)))
      out += taken[0] == '\n' || taken[0] == '\t' ? ' ' : '?';
    else if (taken == "&")
      out += "&amp;";
    else if (taken == "<")
      out += "&lt;";
    else if (taken == ">")
      out += "&gt;";
    else if (taken == "\"")
      out += "&quot;";
    else if (taken == "'")
      out += "&#39;";
    else
      out += taken;
  }
  return out;
}

}  // namespace vacuform
