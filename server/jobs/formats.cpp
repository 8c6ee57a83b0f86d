#include "server/jobs/formats.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "api/base/text.hpp"
#include "api/job.hpp"

namespace vacuform {

namespace {

using namespace std::string_view_literals;

// Zeros and the like, which no text holds.
bool binary(std::string_view head) {
  return std::any_of(head.begin(), head.end(), [](char c) { return static_cast<unsigned char>(c) < 9; });
}

std::string_view first_text(std::string_view head) {
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);  // a mark of UTF-8
  return head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
}

// Files that people take for others, by how they begin.
std::string_view foreign(std::string_view head) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> known{{
      {"PK\x03\x04"sv, "a ZIP archive"},
      {"\x1f\x8b"sv, "a gzip archive"},
      {"Kaydara FBX"sv, "an FBX file"},
      {"%PDF"sv, "a PDF or Adobe Illustrator file"},
      {"ISO-10303-21"sv, "a STEP file"},
      {"# vtk DataFile"sv, "a VTK file"},
      {"<html"sv, "an HTML file"},
      {"<!DOCTYPE html"sv, "an HTML file"},
  }};
  for (const auto& [mark, kind] : known)
    if (head.starts_with(mark)) return kind;
  if (head.size() > 132 && head.substr(128, 4) == "DICM") return "a DICOM image";
  return {};
}

// The same of drawings; the head of a scan may hold anything.
std::string_view foreign_drawing(std::string_view head) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 9> known{{
      {"%!PS-Adobe"sv, "a PostScript, EPS or Adobe Illustrator file"},
      {"\xc5\xd0\xd3\xc6"sv, "an EPS file"},
      {"II*\0"sv, "a TIFF picture"},
      {"MM\0*"sv, "a TIFF picture"},
      {"GIF8"sv, "a GIF picture"},
      {"8BPS"sv, "a Photoshop file"},
      {"AutoCAD Binary DXF"sv, "a binary DXF file"},
      {"AC10"sv, "a DWG file"},
      {"BM"sv, "a BMP picture"},
  }};
  for (const auto& [mark, kind] : known)
    if (head.starts_with(mark)) return kind;
  if (head.starts_with("RIFF") && head.size() > 12 && head.substr(8, 4) == "WEBP") return "a WebP picture";
  return {};
}

std::string_view picture(std::string_view head) {
  if (head.starts_with("\x89PNG\r\n\x1a\n")) return "png";
  if (head.starts_with("\xff\xd8\xff")) return "jpeg";
  return {};
}

bool sizes_as_binary_stl(std::string_view head, std::uint64_t bytes) {
  if (head.size() < 84) return false;
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
    count |= std::uint64_t{static_cast<unsigned char>(head[80 + i])} << (8 * i);
  return 84 + 50 * count == bytes;
}

std::string_view scan_format(std::string_view head, std::uint64_t bytes, std::string_view extension) {
  if (head.starts_with("glTF")) return "glb";
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return "ply";
  if (sizes_as_binary_stl(head, bytes)) return "stl";
  if (!picture(head).empty()) return {};
  if (extension == "stl") return "stl";
  if (binary(head)) return {};
  const std::string_view text = first_text(head);
  if (text.starts_with("solid")) return "stl";
  if (text.substr(0, text.find_first_of(" \t\r\n")).find("OFF") != std::string_view::npos) return "off";
  if (extension == "obj" || text.starts_with("v ") || text.starts_with("mtllib ")) return "obj";
  return {};
}

bool begins_dxf(std::string_view text) {
  const auto line = [&] {
    const std::string_view first = text.substr(0, text.find_first_of("\r\n"));
    text.remove_prefix(std::min(text.size(), first.size()));
    text.remove_prefix(std::min(text.size(), std::size_t{text.starts_with("\r\n") ? 2u : 1u}));
    return trimmed(first);
  };
  const std::string_view code = line(), value = line();
  return code == "999" || (code == "0" && value == "SECTION");
}

std::string_view drawing_format(std::string_view head) {
  if (const auto format = picture(head); !format.empty()) return format;
  return !binary(head) && first_text(head).starts_with('<') ? "svg" : "";
}

std::string_view temperature_format(std::string_view head) {
  if (picture(head) == "png") return "png";
  return !binary(head) && !head.starts_with("\xff\xd8\xff") ? "csv" : "";
}

std::string_view profile_format(std::string_view head) {
  return head.size() >= 40 && head.substr(36, 4) == "acsp" ? "icc" : "";
}

}  // namespace

Result<std::string_view> format_of(std::string_view input, std::string_view head, std::uint64_t bytes,
                                   std::string_view extension) {
  if (input == "scan" && extension == "zip" && head.starts_with("PK\x03\x04")) return "zip";
  std::string_view other = foreign(head), format;
  if (other.empty() && (input == "pattern" || input == "weights")) other = foreign_drawing(head);
  if (other.empty())
    format = input == "scan"          ? scan_format(head, bytes, extension)
             : input == "temperature" ? temperature_format(head)
             : input == "icc"         ? profile_format(head)
             : input == "pattern" && !binary(head) && begins_dxf(first_text(head)) ? "dxf"
                                                                                   : drawing_format(head);
  if (!format.empty()) return format;
  // Redaction makes one SVG of a zip of drawings, and leaves no other zip than that of a model.
  if (extension == "zip" && input == "pattern" && head.starts_with("PK\x03\x04"))
    return fail(Code::unsupported_format, "the zip of the pattern holds a model", std::string(input),
                "give the model as the scan, or a zip with an SVG for each layer");
  if (extension == "zip" && input == "scan" && first_text(head).starts_with('<'))
    return fail(Code::unsupported_format, "the zip of the scan holds drawings", std::string(input),
                "give the drawings as the pattern, or a zip with one OBJ or one PLY");
  const InputKind* kind = input_kind(input);
  return fail(
      Code::unsupported_format,
      "the " + std::string(input) + " is " + (other.empty() ? "of no known format" : std::string(other)),
      std::string(input), "give one of " + std::string(kind ? kind->extensions : ""));
}

}  // namespace vacuform
