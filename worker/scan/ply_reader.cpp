// PLY: a text header that declares elements and their properties, then rows in ASCII or in either byte order. Only x,
// y, z of `vertex` and the list vertex_indices (or vertex_index) of `face` and of `tristrips` are read; everything else
// is skipped by its declared size. Colours are red, green and blue of `vertex`, encoded as sRGB, and the texture
// (ply_texture.hpp). In a strip -1 starts the next one. Turk 1994, "The PLY polygon file format".
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "api/base/text.hpp"
#include "worker/scan/ply_texture.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {
namespace {

enum class Kind { i8, u8, i16, u16, i32, u32, f32, f64 };

bool kind_from(std::string_view word, Kind& kind) {
  constexpr std::pair<std::string_view, Kind> names[] = {
      {"char", Kind::i8},   {"int8", Kind::i8},     {"uchar", Kind::u8},   {"uint8", Kind::u8},
      {"short", Kind::i16}, {"int16", Kind::i16},   {"ushort", Kind::u16}, {"uint16", Kind::u16},
      {"int", Kind::i32},   {"int32", Kind::i32},   {"uint", Kind::u32},   {"uint32", Kind::u32},
      {"float", Kind::f32}, {"float32", Kind::f32}, {"double", Kind::f64}, {"float64", Kind::f64}};
  for (const auto& [name, value] : names)
    if (name == word) return kind = value, true;
  return false;
}

std::uint64_t size_of(Kind kind) {
  switch (kind) {
    case Kind::i8:
    case Kind::u8:
      return 1;
    case Kind::i16:
    case Kind::u16:
      return 2;
    case Kind::i32:
    case Kind::u32:
    case Kind::f32:
      return 4;
    case Kind::f64:
      return 8;
  }
  return 8;
}

enum class Use { none, x, y, z, corners, strip, red, green, blue, u, v, texcoord, texnumber };

bool is_colour(Use use) { return use >= Use::red && use <= Use::blue; }
bool is_texture(Use use) { return use >= Use::u; }

Use colour_from(std::string_view name) {
  if (name.starts_with("diffuse_")) name.remove_prefix(8);
  return name == "red" || name == "r"     ? Use::red
         : name == "green" || name == "g" ? Use::green
         : name == "blue" || name == "b"  ? Use::blue
                                          : Use::none;
}

Use of_vertex(std::string_view name) {
  if (name == "x" || name == "y" || name == "z") return name == "x" ? Use::x : name == "y" ? Use::y : Use::z;
  if (name == "s" || name == "u" || name == "texture_u") return Use::u;
  if (name == "t" || name == "v" || name == "texture_v") return Use::v;
  return colour_from(name);
}

// What full colour is. Bytes count to 255. Other types are used for 0 to 1, for 0 to 255 and for 0 to 65535, and only
// the largest value of all tells which.
double full_colour(Kind kind, float largest) {
  constexpr float rounding = 0.01f;
  if (kind == Kind::u8) return 255;
  if (largest <= 1 + rounding) return 1;
  return largest <= 255 + rounding ? 255 : 65535;
}

// Turns what the file has into linear light.
void settle_colours(std::span<Eigen::Vector3f> colours, Kind kind, std::vector<std::string>& notes) {
  float largest = 0;
  for (const auto& colour : colours) largest = std::max(largest, colour.maxCoeff());
  const auto full = static_cast<float>(full_colour(kind, largest));
  for (auto& colour : colours) colour = (colour / full).unaryExpr(&linear_from_srgb);
  const double usual = kind == Kind::u16 ? 65535 : 1;
  if (kind != Kind::u8 && full != usual && largest > 0)
    notes.push_back("The colours of the PLY file are read as 0 to " + std::to_string(static_cast<int>(full)) +
                    ", as their values say and not their type");
}

struct Property {
  Kind kind = Kind::f32;
  bool list = false;
  Kind count_kind = Kind::u8;
  Use use = Use::none;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

// Consecutive values in any of the three encodings. False if the bytes end or a word is not a number.
class Values {
 public:
  Values(Bytes bytes, bool ascii, bool big) : bytes_(bytes), text_(bytes), ascii_(ascii), big_(big) {}

  bool read(Kind kind, double& value) {
    if (ascii_) return parse_number(text_.next_word(), value);
    const std::uint64_t size = size_of(kind);
    if (bytes_.size() - at_ < size) return false;
    std::uint64_t raw = 0;
    for (std::uint64_t i = 0; i < size; ++i)
      raw |= std::uint64_t{bytes_[at_ + (big_ ? size - 1 - i : i)]} << 8 * i;
    at_ += size;
    switch (kind) {
      case Kind::i8:
        value = static_cast<std::int8_t>(raw);
        break;
      case Kind::u8:
      case Kind::u16:
      case Kind::u32:
        value = static_cast<double>(raw);
        break;
      case Kind::i16:
        value = static_cast<std::int16_t>(raw);
        break;
      case Kind::i32:
        value = static_cast<std::int32_t>(raw);
        break;
      case Kind::f32:
        value = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
        break;
      case Kind::f64:
        value = std::bit_cast<double>(raw);
        break;
    }
    return true;
  }
  bool skip(Kind kind, std::uint64_t count) {
    if (ascii_) {
      for (std::uint64_t i = 0; i < count; ++i)
        if (text_.next_word().empty()) return false;
      return true;
    }
    if (count > (bytes_.size() - at_) / size_of(kind)) return false;
    at_ += count * size_of(kind);
    return true;
  }
  std::uint64_t remaining() const { return ascii_ ? text_.remaining() : bytes_.size() - at_; }

 private:
  Bytes bytes_;
  TextCursor text_;
  std::uint64_t at_ = 0;
  bool ascii_, big_;
};

constexpr std::size_t most_textures = 256;

struct Header {
  enum class Encoding { none, ascii, little, big } encoding = Encoding::none;
  std::vector<Element> elements;
  std::vector<std::string> textures;
  PatientSpace space = PatientSpace::unknown;
  std::uint64_t bytes = 0;  // of the header itself
};

Result<Header> read_header(Bytes bytes, const std::string& where) {
  Header header;
  TextCursor text(bytes);
  std::string_view line;
  const auto at = [&] { return where + ", line " + std::to_string(text.line_number()); };
  text.next_line(line);  // "ply"
  while (text.next_line(line)) {
    const auto word = take_word(line);
    if (word == "end_header") {
      header.bytes = text.position();
      if (header.encoding == Header::Encoding::none)
        return corrupt("the PLY header does not name its format", where);
      return header;
    }
    if (word == "format") {
      const auto format = take_word(line);
      if (format == "ascii")
        header.encoding = Header::Encoding::ascii;
      else if (format == "binary_little_endian")
        header.encoding = Header::Encoding::little;
      else if (format == "binary_big_endian")
        header.encoding = Header::Encoding::big;
      else
        return corrupt("unknown PLY format \"" + std::string(format.substr(0, 40)) + "\"", at());
    } else if (word == "element") {
      Element element;
      element.name = take_word(line);
      std::int64_t count = 0;
      if (!parse_integer(take_word(line), count) || count < 0)
        return corrupt("an element of the PLY header does not say how many it has", at());
      element.count = static_cast<std::uint64_t>(count);
      if (header.elements.size() == 256)
        return corrupt("the PLY header declares more than 256 elements", at());
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty())
        return corrupt("a property of the PLY header stands before any element", at());
      auto& element = header.elements.back();
      Property property;
      auto type = take_word(line);
      if (type == "list") {
        property.list = true;
        if (!kind_from(take_word(line), property.count_kind) || property.count_kind >= Kind::f32)
          return corrupt("the length of a list in the PLY header is not an integer", at());
        type = take_word(line);
      }
      if (!kind_from(type, property.kind))
        return corrupt("unknown PLY property type \"" + std::string(type.substr(0, 40)) + "\"", at());
      const auto name = take_word(line);
      if (element.name == "vertex" && !property.list) property.use = of_vertex(name);
      if (element.name == "face" && name == (property.list ? "texcoord" : "texnumber"))
        property.use = property.list ? Use::texcoord : Use::texnumber;
      if (property.list && (name == "vertex_indices" || name == "vertex_index"))
        property.use = element.name == "face"        ? Use::corners
                       : element.name == "tristrips" ? Use::strip
                                                     : Use::none;
      if (element.properties.size() == 1024)
        return corrupt("a PLY element declares more than 1024 properties", at());
      element.properties.push_back(property);
    } else if (const auto space = find_space(word == "comment" ? line : "").space;
               space != PatientSpace::unknown) {
      if (header.space == PatientSpace::unknown) header.space = space;
    } else if (word == "comment" && take_word(line) == "TextureFile") {
      if (header.textures.size() < most_textures) header.textures.emplace_back(trimmed(line));
    } else if (word != "comment" && word != "obj_info" && !word.empty()) {
      return corrupt("\"" + std::string(word.substr(0, 40)) + "\" is not a keyword of a PLY header", at());
    }
  }
  return corrupt("the PLY header has no end_header", where);
}

// Every other triangle of a strip runs the other way. Those that name a vertex twice only join two parts of it.
void add_strip(const std::vector<double>& corners, std::vector<Triangle>& triangles) {
  for (std::size_t k = 2; k < corners.size(); ++k) {
    const int a = static_cast<int>(corners[k - 2]), b = static_cast<int>(corners[k - 1]),
              c = static_cast<int>(corners[k]);
    if (a == b || b == c || a == c) continue;
    triangles.push_back(k % 2 == 0 ? Triangle{a, b, c} : Triangle{b, a, c});
  }
}

}  // namespace

Result<ScanFile> read_ply(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts, const ModelFiles* files) {
  VACUFORM_TRY(header, read_header(bytes, where));
  const bool ascii = header.encoding == Header::Encoding::ascii;
  ScanFile scan;
  scan.format = ascii                                      ? "PLY (ASCII)"
                : header.encoding == Header::Encoding::big ? "PLY (big-endian)"
                                                           : "PLY (little-endian)";
  auto& [vertices, triangles] = scan.mesh;
  Values values(bytes.subspan(header.bytes), ascii, header.encoding == Header::Encoding::big);
  std::vector<double> corners, texcoord;
  const bool names_textures = !header.textures.empty();
  scan.space = header.space;
  PlyTexture texture(std::move(header.textures), parts == ScanParts::with_colours ? files : nullptr);
  double largest = -1;
  ScanColours colours;

  for (const auto& element : header.elements) {
    bool coloured = false, with_uv = false;
    Kind colour_kind = Kind::u8;
    std::size_t uncoloured = 0;
    // The fewest bytes that a row can take: a word and its separator in ASCII, empty lists in binary.
    std::uint64_t row_bytes = 0;
    for (const auto& p : element.properties) row_bytes += ascii ? 2 : size_of(p.list ? p.count_kind : p.kind);
    if (row_bytes == 0) continue;  // no properties, no bytes
    if (element.count > (values.remaining() + 1) / row_bytes) {
      if (const auto damage = ascii ? std::string() : text_mode_damage(bytes); !damage.empty())
        return corrupt(damage, where);
      return corrupt("the PLY file says it has " + std::to_string(element.count) + " of element \"" +
                         element.name.substr(0, 40) + "\", but only " + std::to_string(values.remaining()) +
                         " bytes follow",
                     where);
    }
    if (element.name == "vertex") {
      if (element.count > scan_limits.vertices)
        return fail(Code::too_large, "the scan has " + std::to_string(element.count) + " vertices", where,
                    "reduce it (quadric decimation) to a few hundred thousand triangles");
      int used = 0;
      for (const auto& p : element.properties) used |= p.use == Use::none ? 0 : 1 << static_cast<int>(p.use);
      if ((used & 0b1110) != 0b1110)
        return corrupt("the vertices of the PLY file do not have x, y and z", where);
      vertices.reserve(vertices.size() + element.count);
      coloured = parts == ScanParts::with_colours && (used >> static_cast<int>(Use::red) & 0b111) == 0b111;
      if (coloured) colours.vertex.resize(vertices.size(), Eigen::Vector3f::Ones());
      for (const auto& p : element.properties)
        if (is_colour(p.use)) colour_kind = p.kind;
      uncoloured = colours.vertex.size();
      with_uv = texture.used() && (used >> static_cast<int>(Use::u) & 0b11) == 0b11;
    }
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (row % 65536 == 0) VACUFORM_CHECK(progress.tick());
      const auto at = [&] { return where + ", " + element.name.substr(0, 40) + " " + std::to_string(row); };
      const auto ended = [&] {
        return corrupt(values.remaining() == 0 || !ascii ? "the PLY file ends within its data"
                                                         : "a word of the PLY data is not a number",
                       at());
      };
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      Eigen::Vector3f colour;
      double uv[2] = {0, 0}, number = 0;
      const std::size_t first_triangle = triangles.size();
      texcoord.clear();
      for (const auto& p : element.properties) {
        double value = 0;
        if (!p.list) {
          const bool skipped =
              p.use == Use::none || (is_colour(p.use) && !coloured) || (is_texture(p.use) && !texture.used());
          if (skipped ? !values.skip(p.kind, 1) : !values.read(p.kind, value)) return ended();
          if (skipped) continue;
          if (is_texture(p.use))
            (p.use == Use::texnumber ? number : uv[p.use == Use::u ? 0 : 1]) = value;
          else if (!is_colour(p.use))
            point[static_cast<int>(p.use) - 1] = value;
          else if (std::isfinite(value))
            colour[static_cast<int>(p.use) - static_cast<int>(Use::red)] = static_cast<float>(value);
          else
            return corrupt("a colour of the PLY file is not a finite number", at());
          continue;
        }
        if (!values.read(p.count_kind, value)) return ended();
        if (!(value >= 0) || value != std::floor(value) || value > static_cast<double>(values.remaining()))
          return corrupt("a list of the PLY file is longer than the file", at());
        const auto length = static_cast<std::uint64_t>(value);
        if (p.use == Use::texcoord && texture.used()) {
          texcoord.resize(length);
          for (double& each : texcoord)
            if (!values.read(p.kind, each)) return ended();
          continue;
        }
        if (p.use == Use::none || p.use == Use::texcoord) {
          if (!values.skip(p.kind, length)) return ended();
          continue;
        }
        corners.clear();
        for (std::uint64_t k = 0; k < length; ++k) {
          double index = 0;
          if (!values.read(p.kind, index)) return ended();
          if (p.use == Use::strip && index == -1) {
            add_strip(corners, triangles);
            corners.clear();
            continue;
          }
          if (!(index >= 0) || index != std::floor(index) ||
              index >= static_cast<double>(scan_limits.vertices))
            return corrupt("a face of the PLY file names a vertex that does not exist", at());
          largest = std::max(largest, index);
          corners.push_back(index);
          if (triangles.size() + corners.size() > scan_limits.triangles + 2)
            return too_many_triangles(triangles.size() + corners.size() - 2, where);
        }
        if (p.use == Use::strip) {
          add_strip(corners, triangles);
          continue;
        }
        for (std::size_t k = 2; k < corners.size(); ++k)
          triangles.push_back(
              {static_cast<int>(corners[0]), static_cast<int>(corners[k - 1]), static_cast<int>(corners[k])});
      }
      if (element.name == "vertex") vertices.push_back(point);
      if (coloured) colours.vertex.push_back(colour);
      if (with_uv) texture.add_vertex(uv[0], uv[1]);
      if (element.name == "face" && texture.used())
        texture.add_face(texcoord, number, first_triangle, triangles.size());
    }
    if (coloured)
      settle_colours(std::span(colours.vertex).subspan(uncoloured), colour_kind, scan.colour_notes);
  }
  if (largest >= static_cast<double>(vertices.size()))
    return corrupt("a face names vertex " + std::to_string(static_cast<std::int64_t>(largest)) +
                       ", but the PLY file has " + std::to_string(vertices.size()) +
                       " vertices, counted from 0",
                   where);
  if (!colours.vertex.empty()) colours.vertex.resize(vertices.size(), Eigen::Vector3f::Ones());
  if (parts == ScanParts::with_colours && names_textures && !files)
    scan.colours_missing.push_back("The PLY names a texture (TextureFile), but its image was not given");
  if (texture.used()) {
    VACUFORM_CHECK(texture.lay(scan.mesh, where, colours));
    scan.colours = std::move(colours);
  } else if (!colours.vertex.empty()) {
    colours.materials.emplace_back();
    colours.material.assign(triangles.size(), 0);
    scan.colours = std::move(colours);
  }
  return scan;
}

}  // namespace vacuform
