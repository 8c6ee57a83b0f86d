#include "api/base/utf8.hpp"

#include <clocale>
#include <cstdio>
#include <cwctype>

namespace vacuform {

std::optional<std::u32string> code_points(std::string_view utf8) {
  std::u32string points;
  for (std::size_t at = 0; at < utf8.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(utf8[i]); };
    const unsigned first = byte(at++);
    const int more = first < 0x80   ? 0
                     : first < 0xc2 ? -1
                     : first < 0xe0 ? 1
                     : first < 0xf0 ? 2
                     : first < 0xf5 ? 3
                                    : -1;
    if (more < 0 || utf8.size() - at < static_cast<std::size_t>(more)) return std::nullopt;
    char32_t point = more == 0 ? first : first & (0x3fu >> more);
    for (int i = 0; i < more; ++i, ++at) {
      if ((byte(at) & 0xc0) != 0x80) return std::nullopt;
      point = point << 6 | (byte(at) & 0x3fu);
    }
    constexpr char32_t least[] = {0, 0x80, 0x800, 0x10000};  // of so many bytes: a longer form is not UTF-8
    if (point < least[more] || point > 0x10ffff || (point >= 0xd800 && point <= 0xdfff)) return std::nullopt;
    points += point;
  }
  return points;
}

namespace {

bool acts(char32_t point) {
  return point < 0x20 || (point >= 0x7f && point < 0xa0) || point == 0x61c || point == 0x200e ||
         point == 0x200f || (point >= 0x2028 && point <= 0x202e) || (point >= 0x2066 && point <= 0x2069) ||
         point == 0xfeff;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t length = 1;
    std::optional<std::u32string> points;
    for (; length <= 4 && at + length <= text.size(); ++length)
      if ((points = code_points(text.substr(at, length)))) break;
    const std::string_view piece = text.substr(at, points ? length : 1);
    at += piece.size();
    if (points && !acts(points->front())) {
      out += piece;
      continue;
    }
    char written[12];
    const unsigned value = points ? points->front() : static_cast<unsigned char>(piece[0]);
    std::snprintf(written, sizeof written, value < 0x100 ? "\\x%02x" : "\\u%04x", value);
    out += written;
  }
  return out;
}

std::string utf8(std::u32string_view points) {
  std::string out;
  for (const char32_t point : points) {
    const int more = point < 0x80 ? 0 : point < 0x800 ? 1 : point < 0x10000 ? 2 : 3;
    constexpr unsigned lead[] = {0, 0xc0, 0xe0, 0xf0};
    out += static_cast<char>(lead[more] | point >> (6 * more));
    for (int i = more - 1; i >= 0; --i) out += static_cast<char>(0x80 | (point >> (6 * i) & 0x3f));
  }
  return out;
}

std::u32string folded(std::string_view utf8) {
  static const locale_t letters = ::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);  // for the whole run
  std::u32string points = code_points(utf8).value_or(std::u32string());
  for (char32_t& point : points)
    point = static_cast<char32_t>(letters ? ::towlower_l(static_cast<wint_t>(point), letters)
                                          : std::towlower(static_cast<wint_t>(point)));
  return points;
}

}  // namespace vacuform
