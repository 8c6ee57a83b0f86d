// Numbers as text, whatever the locale.
#pragma once

#include <charconv>
#include <string>

namespace vacuform {

// With `places` digits behind the point, never "-0".
inline std::string decimal(double value, int places) {
  char text[400];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, places).ptr;
  std::string out(text, end);
  if (out.front() == '-' && out.find_first_of("123456789") == std::string::npos) out.erase(0, 1);
  return out;
}

inline std::string in_mm(double value) { return decimal(value, 1) + " mm"; }
inline std::string in_percent(double share, int places = 0) { return decimal(100 * share, places) + " %"; }

// With at most `digits` digits that count, without needless zeros: 300, 0.75, 12.3.
inline std::string short_decimal(double value, int digits = 4) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr;
  return {text, end};
}

}  // namespace vacuform
