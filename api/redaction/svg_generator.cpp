#include "api/redaction/svg_generator.hpp"

#include "api/base/text.hpp"

namespace vacuform {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string svg_inkscape_version(std::string_view value) {
  constexpr std::size_t most_parts = 3, most_digits = 4;
  value = trimmed(value);
  std::size_t end = 0;
  for (std::size_t part = 0; part < most_parts; ++part) {
    const std::size_t first = part == 0 ? 0 : end + 1;
    std::size_t last = first;
    while (last < value.size() && is_digit(value[last])) ++last;
    if (last == first) break;
    if (last - first > most_digits) return {};
    end = last;
    if (end == value.size() || value[end] != '.') break;
  }
  const bool more =
      end < value.size() && value[end] == '.' && end + 1 < value.size() && is_digit(value[end + 1]);
  return more ? std::string() : std::string(value.substr(0, end));
}

std::string svg_generator_comment(std::string_view comment) {
  constexpr std::string_view mark = "Generator: Adobe Illustrator";
  comment = trimmed(comment);
  if (!comment.starts_with(mark)) return {};
  const std::string_view rest = comment.substr(mark.size());
  if (!rest.empty() && rest.front() != ' ' && rest.front() != ',') return {};
  const std::string version = svg_inkscape_version(rest);
  return std::string(mark) + (version.empty() ? "" : " ") + version;
}

}  // namespace vacuform
