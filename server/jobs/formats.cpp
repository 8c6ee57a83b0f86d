#include "server/jobs/formats.hpp"

#include <algorithm>
#include <array>
#include <utility>

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
      {"%PDF"sv, "a PDF file"},
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
  const std::string_view other = foreign(head);
  std::string_view format;
  if (other.empty())
    format = input == "scan"          ? scan_format(head, bytes, extension)
             : input == "temperature" ? temperature_format(head)
             : input == "icc"         ? profile_format(head)
                                      : drawing_format(head);
  if (!format.empty()) return format;
  const InputKind* kind = input_kind(input);
  return fail(
      Code::unsupported_format,
      "the " + std::string(input) + " is " + (other.empty() ? "of no known format" : std::string(other)),
      std::string(input), "give one of " + std::string(kind ? kind->extensions : ""));
}

}  // namespace vacuform
