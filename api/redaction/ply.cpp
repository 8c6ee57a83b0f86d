// PLY: a text header that declares elements and their properties, then rows in ASCII or in either byte order (Turk 1994, "The
// PLY polygon file format"). The rows are walked to find where they end: nobody reads what comes after them.
#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <vector>

#include "api/base/patient_space.hpp"
#include "api/base/text.hpp"
#include "api/redaction/formats.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::size_t longest_header = 1 << 20;
constexpr std::array<std::string_view, 5> element_names{"vertex", "face", "tristrips", "edge", "material"};
constexpr std::array<std::string_view, 34> property_names{"x",
                                                          "y",
                                                          "z",
                                                          "nx",
                                                          "ny",
                                                          "nz",
                                                          "red",
                                                          "green",
                                                          "blue",
                                                          "alpha",
                                                          "r",
                                                          "g",
                                                          "b",
                                                          "a",
                                                          "diffuse_red",
                                                          "diffuse_green",
                                                          "diffuse_blue",
                                                          "s",
                                                          "t",
                                                          "u",
                                                          "v",
                                                          "texture_u",
                                                          "texture_v",
                                                          "vertex_indices",
                                                          "vertex_index",
                                                          "texcoord",
                                                          "texnumber",
                                                          "quality",
                                                          "confidence",
                                                          "intensity",
                                                          "flags",
                                                          "material_index",
                                                          "vertex1",
                                                          "vertex2"};
constexpr std::array<std::string_view, 3> encodings{"ascii", "binary_little_endian", "binary_big_endian"};

struct Type {
  std::string_view name;
  int bytes;
  bool is_signed = false;
};
constexpr std::array<Type, 16> types{{{"char", 1, true},
                                      {"int8", 1, true},
                                      {"uchar", 1},
                                      {"uint8", 1},
                                      {"short", 2, true},
                                      {"int16", 2, true},
                                      {"ushort", 2},
                                      {"uint16", 2},
                                      {"int", 4, true},
                                      {"int32", 4, true},
                                      {"uint", 4},
                                      {"uint32", 4},
                                      {"float", 4},
                                      {"float32", 4},
                                      {"double", 8},
                                      {"float64", 8}}};

struct Property {
  int count_bytes = 0;  // of the length of a list; 0: a single value
  int bytes = 0;
};
struct Element {
  std::uint64_t rows = 0;
  std::vector<Property> properties;
};

std::uint64_t number_of(std::string_view word) {
  std::uint64_t number = 0;
  std::from_chars(word.data(), word.data() + word.size(), number);
  return number;
}

class Ply {
 public:
  Ply(Cursor& in, Copy& out, const TextureName& texture) : in_(in), out_(out), texture_(texture) {}

  Result<void> copy() {
    for (std::size_t bytes = 0; bytes < longest_header;) {
      VACUFORM_TRY(line, in_.line());
      if (line.empty()) return {};
      bytes += line.size();
      const std::string_view text = line.substr(0, line.find_first_of("\r\n"));
      const std::string end(line.substr(text.size()));
      const bool last = trimmed(text) == "end_header";
      VACUFORM_TRY(kept, header_line(text));
      VACUFORM_CHECK(out_.write(kept.append(end)));
      if (!last) continue;
      return encoding_ == "ascii" ? all_words() : all_rows();
    }
    return {};
  }

 private:
  // The words of a line that a reader of the geometry uses; question marks in place of others.
  Result<std::string> header_line(std::string_view line) {
    std::string_view rest = line;
    const std::string_view word = next_word(rest);
    const auto known = [](std::string_view name, const auto& names, const char* other) {
      return std::string(one_of(name, names) ? name : other);
    };
    if (const NamedSpace named = find_space(word == "comment" ? rest : ""); named.size > 0)
      return "comment SPACE=" + std::string(name(named.space));
    if (word == "comment" && texture_ && next_word(rest) == "TextureFile") {
      VACUFORM_TRY(name, texture_(trimmed(rest)));
      return "comment TextureFile " + name;
    }
    if (word == "comment" || word == "obj_info") return std::string(word);
    if (word == "format") {
      encoding_ = next_word(rest);
      const std::string_view version = next_word(rest);
      return "format " + known(encoding_, encodings, "?") + " " +
             (is_number(version) ? std::string(version) : "?");
    }
    if (word == "element") {
      const std::string_view name = next_word(rest), rows = next_word(rest);
      elements_.push_back({is_number(rows) ? number_of(rows) : 0, {}});
      return "element " + known(name, element_names, "other") + " " +
             (is_number(rows) ? std::string(rows) : "?");
    }
    if (word == "property") {
      std::string text = "property ";
      Property property;
      std::string_view type = next_word(rest);
      if (type == "list") {
        const std::string_view count = next_word(rest);
        property.count_bytes = bytes_of(count);
        text += "list " + name_of(count) + " ";
        type = next_word(rest);
      }
      property.bytes = bytes_of(type);
      if (!elements_.empty()) elements_.back().properties.push_back(property);
      return text + name_of(type) + " " + known(next_word(rest), property_names, "other");
    }
    return std::string(word == "ply" || word == "end_header" || word.empty() ? word : "?");
  }

  static std::string_view next_word(std::string_view& rest) {
    rest = trimmed(rest);
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
    rest.remove_prefix(word.size());
    return word;
  }
  static const Type* type_of(std::string_view name) {
    const auto at =
        std::find_if(types.begin(), types.end(), [&](const Type& type) { return type.name == name; });
    return at == types.end() ? nullptr : &*at;
  }
  // An unknown type makes the reader refuse the file, whatever follows.
  static std::string name_of(std::string_view type) { return std::string(type_of(type) ? type : "?"); }
  static int bytes_of(std::string_view type) { return type_of(type) ? type_of(type)->bytes : 1; }

  Result<void> all_words() {
    for (const Element& element : elements_) {
      VACUFORM_TRY(whole, words(element));
      if (!whole) return {};
    }
    return out_.write("\n");
  }
  Result<void> all_rows() {
    for (const Element& element : elements_) VACUFORM_CHECK(rows(element));
    return {};
  }

  // The rows of a binary file.
  Result<void> rows(const Element& element) {
    std::uint64_t fixed = 0;
    bool lists = false;
    for (const Property& p : element.properties)
      fixed += static_cast<std::uint64_t>(p.bytes), lists |= p.count_bytes > 0;
    if (fixed == 0) return {};
    if (!lists) return out_.from(in_, element.rows > all_bytes / fixed ? all_bytes : element.rows * fixed);
    for (std::uint64_t row = 0; row < element.rows; ++row) {
      for (const Property& p : element.properties) {
        std::uint64_t count = 1;
        if (p.count_bytes > 0) {
          VACUFORM_TRY(length, in_.take(static_cast<std::size_t>(p.count_bytes)));
          if (length.empty()) return {};  // the file ends here
          VACUFORM_CHECK(out_.write(length));
          count = length_of(length);
        }
        VACUFORM_CHECK(out_.from(in_, count * static_cast<std::uint64_t>(p.bytes)));
      }
    }
    return {};
  }
  std::uint64_t length_of(std::string_view bytes) const {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      number = number << 8 | static_cast<unsigned char>(
                                 encoding_ == "binary_big_endian" ? bytes[i] : bytes[bytes.size() - 1 - i]);
    return number;
  }

  // The rows of a text. False: the file ends before.
  Result<bool> words(const Element& element) {
    std::uint64_t values = 0;  // behind one another, without a list
    for (std::uint64_t row = 0; row < element.rows && !element.properties.empty(); ++row)
      for (const Property& p : element.properties) {
        if (++values, p.count_bytes == 0) continue;
        VACUFORM_TRY(whole, copy_words(values));
        if (!whole) return false;
        values = last_;
      }
    return copy_words(values);
  }
  // Copies so many words with the white space before each; the value of the last one as a count goes to last_. False: the
  // file ends before.
  Result<bool> copy_words(std::uint64_t count) {
    while (count > 0) {
      VACUFORM_TRY(some, in_.some());
      if (some.empty()) return false;
      std::size_t done = 0;
      while (count > 0) {
        std::size_t begin = done;
        while (begin < some.size() && is_white(some[begin])) ++begin;
        std::size_t end = begin;
        while (end < some.size() && !is_white(some[end])) ++end;
        VACUFORM_CHECK(out_.write(some.substr(done, begin - done)));
        done = begin;
        if (end == some.size()) break;  // the word may go on
        VACUFORM_CHECK(write_word(some.substr(begin, end - begin)));
        done = end;
        --count;
      }
      in_.drop(done);
      if (count == 0 || done == some.size()) continue;
      VACUFORM_TRY(word, in_.word());
      VACUFORM_CHECK(write_word(word));
      --count;
    }
    return true;
  }
  Result<void> write_word(std::string_view word) {
    const bool number = is_number(word);
    last_ = number ? number_of(word) : 0;
    return out_.write(number ? word : "?");
  }

  Cursor& in_;
  Copy& out_;
  const TextureName& texture_;
  std::string encoding_;
  std::vector<Element> elements_;
  std::uint64_t last_ = 0;
};

}  // namespace

Result<void> ply(Cursor& in, Copy& out, const TextureName& texture) { return Ply(in, out, texture).copy(); }

}  // namespace vacuform::redaction
