#include "api/job_text.hpp"

#include <algorithm>
#include <iterator>

#include "api/base/utf8.hpp"

namespace vacuform {

namespace {

struct Span {
  char32_t first, last;
};
constexpr bool in(char32_t c, const Span& span) { return c >= span.first && c <= span.last; }

bool is_control(char32_t c) { return c < 0x20 || in(c, {0x7f, 0x9f}); }

// Control and format characters, line separators, private use, tags, and code points that are no characters.
bool is_hidden(char32_t c) {
  constexpr Span spans[] = {{0xad, 0xad},     {0x61c, 0x61c},   {0x180e, 0x180e},   {0x200b, 0x200f},
                            {0x2028, 0x202e}, {0x2060, 0x206f}, {0xe000, 0xf8ff},   {0xfdd0, 0xfdef},
                            {0xfeff, 0xfeff}, {0xfff9, 0xfffb}, {0xe0000, 0x10ffff}};
  return is_control(c) || (c & 0xfffe) == 0xfffe ||
         std::any_of(std::begin(spans), std::end(spans), [c](const Span& span) { return in(c, span); });
}

bool is_blank(char32_t c) {
  return c == ' ' || in(c, {0x09, 0x0d}) || c == 0xa0 || in(c, {0x2000, 0x200a}) || c == 0x202f ||
         c == 0x205f || c == 0x3000;
}

std::u32string_view without_blanks(std::u32string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Browsers end a line with "\r\n".
std::u32string with_line_feeds(std::u32string_view text) {
  std::u32string out;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] != '\r')
      out += text[i];
    else if (i + 1 == text.size() || text[i + 1] != '\n')
      out += '\n';
  return out;
}

Result<std::string> cleaned_text(std::string_view text, const char* field, std::size_t longest, bool lines) {
  const auto points = code_points(text);
  if (!points)
    return fail(Code::bad_usage, std::string("the ") + field + " is not UTF-8 text", field, "send UTF-8");
  const std::u32string whole = lines ? with_line_feeds(*points) : *points;
  const std::u32string_view kept = without_blanks(whole);
  const bool bad = std::any_of(kept.begin(), kept.end(), [lines](char32_t c) {
    return lines ? is_control(c) && c != '\n' : is_hidden(c);
  });
  if (bad)
    return fail(Code::bad_usage,
                std::string("the ") + field +
                    (lines ? " contains control characters" : " is not one line of printable characters"),
                field,
                lines ? "use letters, digits, punctuation and line breaks"
                      : "use letters, digits, spaces and punctuation");
  if (kept.size() > longest)
    return fail(Code::bad_usage,
                std::string("the ") + field + " has " + std::to_string(kept.size()) + " characters", field,
                "give at most " + std::to_string(longest));
  return utf8(kept);
}

}  // namespace

Result<std::string> clean_reference(std::string_view text) {
  return cleaned_text(text, "reference", longest_reference, false);
}

Result<std::string> clean_note(std::string_view text) {
  return cleaned_text(text, "note", longest_note, true);
}

}  // namespace vacuform
