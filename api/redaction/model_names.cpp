#include "api/redaction/model_names.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "api/base/patient_space.hpp"
#include "api/base/text.hpp"

namespace vacuform {

namespace {

constexpr std::string_view blanks = " \t\r\v\f";

std::string_view next_word(std::string_view& rest) {
  rest = rest.substr(std::min(rest.find_first_not_of(blanks), rest.size()));
  const std::string_view word = rest.substr(0, std::min(rest.find_first_of(blanks), rest.size()));
  rest.remove_prefix(word.size());
  return word;
}

// Of numbers, of the corners of faces, and between them.
bool numeric(char c) {
  switch (c) {
    case '+':
    case '-':
    case '.':
    case 'e':
    case 'E':
    case '/':
    case '\\':
    case ' ':
    case '\t':
      return true;
    default:
      return c >= '0' && c <= '9';
  }
}

// The numbers of a line; anything else ends them.
std::string_view numbers_of(std::string_view rest) {
  const auto end = std::find_if_not(rest.begin(), rest.end(), numeric);
  rest = rest.substr(0, static_cast<std::size_t>(end - rest.begin()));
  return trimmed(rest, blanks);
}

bool is_number(std::string_view word) {
  return !word.empty() && std::string_view("0123456789+-.").find(word[0]) != std::string_view::npos &&
         std::all_of(word.begin(), word.end(), [](char c) { return numeric(c) && c != '/' && c != '\\'; });
}

std::string base_name(std::string_view path) {
  const std::size_t slash = path.find_last_of("/\\");
  return lower(slash == std::string_view::npos ? path : path.substr(slash + 1));
}

constexpr std::array<std::string_view, 7> model_numbers{"v", "vn", "vt", "f", "l", "p", "s"};
// Options of a map that take one word; -mm takes two, and these up to three numbers: Wavefront, "MTL material format".
constexpr std::array<std::string_view, 8> of_one_word{"-blendu", "-blendv", "-boost",   "-bm",
                                                      "-cc",     "-clamp",  "-imfchan", "-texres"};
constexpr std::array<std::string_view, 3> of_numbers{"-o", "-s", "-t"};

}  // namespace

Result<std::string> plain_path(std::string_view path, const std::string& where) {
  std::string plain(path);
  std::replace(plain.begin(), plain.end(), '\\', '/');
  const auto refuse = [&](const char* what) {
    return fail(Code::corrupt_file, std::string(what) + ": " + plain.substr(0, 100), where,
                "name files relative to the model, below its folder");
  };
  if (plain.starts_with('/') || plain.find(':') != std::string::npos) return refuse("a path is absolute");
  for (std::size_t at = 0; at <= plain.size();) {
    const std::size_t end = std::min(plain.find('/', at), plain.size());
    if (plain.compare(at, end - at, "..") == 0) return refuse("a path leads to a parent folder");
    at = end + 1;
  }
  return plain;
}

ModelNames::Texture& ModelNames::entry(std::string_view path) {
  Texture& texture = textures_[base_name(path)];
  if (texture.number == 0) texture.number = static_cast<int>(textures_.size());
  return texture;
}

Result<int> ModelNames::texture(std::string_view path, const std::string& file) {
  VACUFORM_TRY(plain, plain_path(path, file));
  Texture& texture = entry(plain);
  texture.path = std::move(plain);
  return texture.number;
}

int ModelNames::texture_there(std::string_view path) { return entry(path).number; }

ModelNames::Material& ModelNames::material(std::string_view name) {
  const auto found = materials_.find(name);
  if (found != materials_.end()) return found->second;
  Material& material = materials_[std::string(name)];
  material.number = static_cast<int>(materials_.size());
  return material;
}

int ModelNames::used_material(std::string_view name) {
  Material& found = material(name);
  found.used = true;
  return found.number;
}

int ModelNames::defined_material(std::string_view name) {
  Material& found = material(name);
  found.defined = true;
  return found.number;
}

Result<void> ModelLines::take(std::string_view line, std::string& out) {
  ++line_;
  if (line_ == 1 && line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // a mark of UTF-8
  std::string_view rest = line;
  Result<void> done;
  if (goes_on_) {  // a face that continues the last line
    out += numbers_of(rest);
  } else {
    const std::string_view word = next_word(rest);
    if (kind_ == Kind::obj)
      obj(word, rest, out);
    else
      done = mtl(word, rest, out);
  }
  goes_on_ = kind_ == Kind::obj && out.ends_with('\\');
  out += '\n';
  return done;
}

void ModelLines::obj(std::string_view word, std::string_view rest, std::string& out) {
  if (one_of(word, model_numbers))
    out.append(word).append(" ").append(numbers_of(rest));
  else if (word == "usemtl")
    out.append("usemtl m").append(std::to_string(names_.used_material(trimmed(rest))));
  else if (word == "mtllib")
    out += "mtllib model.mtl";
  else if (const NamedSpace named = find_space(word.starts_with('#') ? rest : ""); named.size > 0)
    out.append("# SPACE=").append(name(named.space));
}

Result<void> ModelLines::mtl(std::string_view word, std::string_view rest, std::string& out) {
  if (word == "newmtl")
    out.append("newmtl m").append(std::to_string(names_.defined_material(trimmed(rest))));
  else if (equal_ignoring_case(word, "Kd"))  // its case stays: the reader tells of a wrong one
    out.append(word).append(" ").append(numbers_of(rest));
  else if (lower(word) == "map_kd")
    return map(rest, out);
  return {};
}

// The options that lay the image, and its number. A file name may contain blanks.
Result<void> ModelLines::map(std::string_view rest, std::string& out) {
  out += "map_Kd";
  for (;;) {
    std::string_view after = rest;
    const std::string_view option = next_word(after);
    if (one_of(option, of_numbers)) {
      std::string values;
      for (int k = 0; k < 3; ++k) {
        std::string_view behind = after;
        const std::string_view number = next_word(behind);
        if (!is_number(number)) break;
        values.append(" ").append(number);
        after = behind;
      }
      if (option != "-t") out.append(" ").append(option).append(values);
    } else if (one_of(option, of_one_word) || option == "-mm") {
      const std::string_view value = next_word(after);
      if (option == "-mm") next_word(after);
      if (option == "-clamp" && value == "on") out += " -clamp on";
    } else {
      break;
    }
    rest = after;
  }
  const std::string_view name = trimmed(rest);
  if (name.empty())
    return fail(Code::corrupt_file, "map_Kd names no image", "the MTL, line " + std::to_string(line_),
                "export the model again");
  VACUFORM_TRY(number, names_.texture(name, "the MTL, line " + std::to_string(line_)));
  out.append(" texture-").append(std::to_string(number));
  return {};
}

}  // namespace vacuform
