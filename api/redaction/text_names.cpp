#include "api/redaction/text_names.hpp"

#include <algorithm>
#include <array>

#include "api/base/text.hpp"

namespace vacuform {

namespace {

// What becomes of a line, once its first word is known.
struct Line {
  bool word = true, rest = true;  // kept
};

constexpr std::string_view solid = "solid";
constexpr std::array<std::string_view, 5> stl_words{"facet", "outer", "vertex", "endloop", "endfacet"};
constexpr std::array<std::string_view, 8> obj_numbers{"v", "vn", "vt", "vp", "f", "l", "p", "s"};
constexpr std::array<std::string_view, 4> obj_names{"o", "g", "usemtl", "mtllib"};

class TextNames : public NameFilter::Format {
 public:
  explicit TextNames(TextKind kind) : kind_(kind) {}

  void take(std::string_view in, std::string& out) override {
    for (std::size_t i = 0; i < in.size(); ++i) {
      if (passing_) {
        out += in.substr(i);
        return;
      }
      step(in[i], out);
    }
  }
  void end(std::string& out) override { decide(out); }
  void fields(FilterState& state) override {
    state(held_, line_.word, line_.rest, decided_, passing_, last_);
  }

 private:
  void step(char c, std::string& out) {
    if (c == '\n' || c == '\r') {
      decide(out);
      out += c;
      decided_ = kind_ == TextKind::obj && last_ == '\\';  // a face that goes on in the next line
      line_ = {};
      last_ = c == '\r' ? last_ : '\0';
      return;
    }
    const bool comment = comment_sign(c);
    if (!decided_) {
      const bool blank = c == ' ' || c == '\t';
      if (blank && held_.empty()) return put(c, true, out);
      if (!blank && !comment && held_.size() < longest_word) {
        held_ += c;
        return;
      }
      decide(out);
    }
    if (comment) line_.rest = false;
    if (line_.rest && c != ' ' && c != '\t') last_ = c;
    put(c, line_.rest, out);
  }

  // Ends the first word, if it has not ended yet.
  void decide(std::string& out) {
    if (decided_) return;
    line_ = line_of(held_);
    // "solidJane" is a file that begins with "solid", and stays one.
    const bool grown = kind_ == TextKind::stl && !line_.word && held_.starts_with(solid);
    for (std::size_t i = 0; i < held_.size(); ++i)
      put(held_[i], line_.word || (grown && i < solid.size()), out);
    if (line_.word && !held_.empty()) last_ = held_.back();
    held_.clear();
    decided_ = true;
  }

  Line line_of(std::string_view word) {
    switch (kind_) {
      case TextKind::stl:
        if (word == "solid" || word == "endsolid") return {true, false};
        // Everything else is a part of a name, which may go over several lines, before the facets or after them.
        return one_of(word, stl_words) ? Line{true, true} : Line{false, false};
      case TextKind::obj:
        if (one_of(word, obj_names)) return {true, false};
        return {one_of(word, obj_numbers), one_of(word, obj_numbers)};
      case TextKind::ply:
        passing_ = word == "end_header";
        return {true, word != "comment" && word != "obj_info"};
      case TextKind::off:
      case TextKind::csv:
        break;
    }
    return {};
  }

  // Of a table only at the beginning of a line: elsewhere it is a cell that its reader refuses.
  bool comment_sign(char c) const {
    const bool begins = !decided_ && (held_.empty() || held_ == "\xef\xbb\xbf");
    return c == '#' &&
           (kind_ == TextKind::obj || kind_ == TextKind::off || (kind_ == TextKind::csv && begins));
  }
  static void put(char c, bool kept, std::string& out) { out += kept || c == '\t' ? c : ' '; }

  static constexpr std::size_t longest_word = 12;  // longer ones are no keyword
  const TextKind kind_;
  std::string held_;  // the first word of the line, until it has ended
  Line line_;
  bool decided_ = false, passing_ = false;
  char last_ = '\0';  // of what was kept of the line, but blanks
};

}  // namespace

std::unique_ptr<NameFilter::Format> text_names(TextKind kind) { return std::make_unique<TextNames>(kind); }

}  // namespace vacuform
