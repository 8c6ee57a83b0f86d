// STL, OBJ, OFF and tables as text. Every line keeps its length.
#include <algorithm>
#include <array>

#include "api/base/patient_space.hpp"
#include "api/base/text.hpp"
#include "api/redaction/formats.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::array<std::string_view, 5> stl_words{"facet", "outer", "vertex", "endloop", "endfacet"};
constexpr std::array<std::string_view, 2> stl_more{"normal", "loop"};
constexpr std::array<std::string_view, 2> stl_ended{"loop", "facet"};  // as in "end loop"
constexpr std::array<std::string_view, 8> obj_numbers{"v", "vn", "vt", "vp", "f", "l", "p", "s"};
constexpr std::array<std::string_view, 4> obj_names{"o", "g", "usemtl", "mtllib"};

// One line, which loses its names in place.
class Line {
 public:
  void begin(std::string_view text, bool signs_separate) {
    text_ = text;
    separate_ = signs_separate;
    begin_ = end_ = 0;
  }
  const std::string& text() const { return text_; }

  // The next word, as the line has it now; empty at the end.
  std::string_view word() {
    for (begin_ = end_; begin_ < text_.size() && between(text_[begin_]); ++begin_) {
    }
    for (end_ = begin_; end_ < text_.size() && !between(text_[end_]); ++end_) {
    }
    return std::string_view(text_).substr(begin_, end_ - begin_);
  }
  void blank_from_start() { fill(0, text_.size(), ' '); }
  void blank_from_word() { fill(begin_, text_.size(), ' '); }
  void blank_after_word() { fill(end_, text_.size(), ' '); }
  void keep_letters_of_word(std::size_t count) { fill(begin_ + count, text_.size(), ' '); }
  // Of what follows the word, only the axes of the patient stay.
  void keep_space_after_word() { keep_space(end_); }
  void blank_comment() {
    const std::size_t sign = text_.find('#');
    if (sign != std::string::npos) fill(sign, text_.size(), ' ');
  }
  // Whether the line is a comment that names axes. They stay, with the sign.
  bool keep_space_of_comment() {
    const std::size_t sign = text_.find_first_not_of(" \t");
    if (sign == std::string::npos || text_[sign] != '#' || !keep_space(sign)) return false;
    text_[sign] = '#';
    return true;
  }
  // Question marks in place of the words that come, unless they are numbers or `also` knows them.
  template <class Also>
  void numbers(const Also& also) {
    for (std::string_view w = word(); !w.empty(); w = word())
      if (!is_number(w) && !also(w)) fill(begin_, end_, '?');
  }

 private:
  bool between(char c) const { return is_white(c) || (separate_ && (c == ',' || c == ';' || c == '"')); }
  bool keep_space(std::size_t from) {
    const NamedSpace named = find_space(std::string_view(text_).substr(from));
    fill(from, text_.size(), ' ');
    if (named.size > 0)
      text_.replace(from + named.begin, named.size, "SPACE=" + std::string(name(named.space)));
    return named.size > 0;
  }
  void fill(std::size_t from, std::size_t to, char c) {
    for (std::size_t i = from; i < to; ++i)
      if (!is_white(text_[i])) text_[i] = c;
  }

  std::string text_;
  bool separate_ = false;  // commas, semicolons and quotes stand between words
  std::size_t begin_ = 0, end_ = 0;
};

// The columns of a table of points (worker/forming/heat/measured_field.hpp).
bool column(std::string_view word) {
  constexpr std::array<std::string_view, 5> columns{"s", "t", "s_mm", "t_mm", "celsius"};
  return one_of(lower(word), columns);
}

void stl(Line& line) {
  const std::string word = lower(line.word());
  if (word == "solid") return line.keep_space_after_word();
  if (word == "endsolid") return line.blank_after_word();
  if (word == "end") {
    const std::string ended = lower(line.word());
    return one_of(ended, stl_ended) ? line.blank_after_word() : line.blank_from_start();
  }
  // Everything else is a part of a name, which may go over several lines, before the facets or after them.
  if (one_of(word, stl_words))
    line.numbers([](std::string_view w) { return one_of(lower(w), stl_more); });
  else
    line.keep_letters_of_word(
        word.starts_with("solid") ? 5 : 0);  // "solidJane" is a file that begins with "solid"
}

// The corners of a face are numbers with slashes between them; a backslash continues the line.
bool corner(std::string_view word) {
  return word == "\\" || word == "off" || std::all_of(word.begin(), word.end(), [](char c) {
           return (c >= '0' && c <= '9') || c == '/' || c == '-' || c == '\\';
         });
}
void obj(Line& line, bool& goes_on) {
  if (line.keep_space_of_comment()) return;
  line.blank_comment();
  if (!goes_on) {
    const std::string_view word = line.word();
    if (one_of(word, obj_names)) return line.blank_after_word();
    if (!one_of(word, obj_numbers)) return line.blank_from_word();
  }
  line.numbers(corner);
  goes_on = trimmed(line.text()).ends_with('\\');
}

bool off_word(std::string_view word) {
  return word == "BINARY" || (word.ends_with("OFF") && word.size() <= 8 &&
                              word.find_first_not_of("STCN4nOF") == std::string_view::npos);
}

}  // namespace

bool is_number(std::string_view word) {
  bool digit = false, other = false;
  for (const char c : word) {
    digit |= c >= '0' && c <= '9';
    other |= (c < '0' || c > '9') && c != '.' && c != '-' && c != '+' && c != 'e' && c != 'E';
  }
  if (digit && !other) return true;
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return equal_ignoring_case(word, "nan") || equal_ignoring_case(word, "inf") ||
         equal_ignoring_case(word, "infinity");
}

Result<void> text(TextKind kind, Cursor& in, Copy& out) {
  bool goes_on = false;  // the last line of an OBJ file ends with a backslash
  Line line;
  for (;;) {
    VACUFORM_TRY(next, in.line());
    if (next.empty()) return {};
    line.begin(next, kind == TextKind::csv);
    switch (kind) {
      case TextKind::stl:
        stl(line);
        break;
      case TextKind::obj:
        obj(line, goes_on);
        break;
      case TextKind::off:
        line.blank_comment();
        line.numbers(off_word);
        break;
      case TextKind::csv:  // elsewhere the sign is a cell that the reader refuses
        if (trimmed(next).starts_with('#')) line.blank_comment();
        line.numbers(column);
        break;
    }
    VACUFORM_CHECK(out.write(line.text()));
  }
}

}  // namespace vacuform::redaction
