#include "worker/scan/scan_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "api/base/text.hpp"
#include "worker/scan/model_zip.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {
namespace {

enum class Format { stl_binary, stl_ascii, obj, ply, off, glb, zip };

std::string_view as_text(Bytes bytes, std::size_t limit) {
  return {reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), limit)};
}

std::string extension_of(const std::string& file_name) {
  const auto dot = file_name.rfind('.');
  if (dot == std::string::npos || file_name.find_first_of("/\\", dot) != std::string::npos) return {};
  return lower(file_name.substr(dot + 1));
}

// Files that people mistake for scans, by their first bytes.
std::string_view kind_of_other_file(Bytes bytes) {
  const std::string_view head = as_text(bytes, 512);
  if (head.starts_with("PK\x03\x04")) return "a ZIP archive (3MF, or packed files)";
  if (head.starts_with("\x1f\x8b")) return "a gzip archive";
  if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff")) return "a text in UTF-16";
  if (head.starts_with("Kaydara FBX")) return "an FBX file";
  if (head.starts_with("\x89PNG") || head.starts_with("\xff\xd8\xff")) return "a picture";
  if (head.starts_with("%PDF")) return "a PDF file";
  if (head.starts_with("ISO-10303-21")) return "a STEP file";
  if (head.starts_with("# vtk DataFile")) return "a VTK file";
  if (head.size() > 132 && head.substr(128, 4) == "DICM") return "a DICOM image, not a surface";
  if (head.size() > 348 && (head.substr(344, 3) == "n+1" || head.substr(344, 3) == "ni1"))
    return "a NIfTI image, not a surface";
  if (head.starts_with("{") && head.find("\"asset\"") != head.npos) return "a glTF file in text form";
  if (head.starts_with("<?xml") || head.starts_with("<COLLADA") || head.starts_with("<!DOCTYPE") ||
      head.starts_with("<html"))
    return "an XML or HTML file";
  return {};
}

bool sizes_as_binary_stl(Bytes bytes) {
  if (bytes.size() < 84) return false;
  const std::uint64_t count = std::uint64_t{bytes[80]} | std::uint64_t{bytes[81]} << 8 |
                              std::uint64_t{bytes[82]} << 16 | std::uint64_t{bytes[83]} << 24;
  return 84 + 50 * count == bytes.size();
}

// Editors of Windows put it before a text in UTF-8.
Bytes without_mark(Bytes bytes) { return as_text(bytes, 3) == "\xef\xbb\xbf" ? bytes.subspan(3) : bytes; }

// "solid" and, after a name of any length, the word facet or endsolid at the start of a line.
bool looks_like_ascii_stl(Bytes bytes) {
  TextCursor text(bytes);
  if (!equal_ignoring_case(text.next_word(), "solid")) return false;
  std::string_view line;
  while (text.next_line(line)) {
    if (line.find('\0') != line.npos) return false;
    const auto word = take_word(line);
    if (equal_ignoring_case(word, "facet") || equal_ignoring_case(word, "endsolid")) return true;
  }
  return false;
}

bool looks_like_obj(Bytes bytes) {
  TextCursor text(bytes);
  std::string_view line;
  for (int i = 0; i < 1000 && text.next_line(line); ++i) {
    if (line.find('\0') != line.npos) return false;
    const auto word = take_word(line);
    if (word.empty() || word.front() == '#') continue;
    double x = 0;
    if (word == "v") return parse_number(take_word(line), x);
    if (word != "mtllib" && word != "o" && word != "g" && word != "s" && word != "usemtl" && word != "vn" &&
        word != "vt")
      return false;
  }
  return false;
}

std::optional<Format> recognise(Bytes bytes, const std::string& extension) {
  const std::string_view head = as_text(bytes, 64);
  if (head.starts_with("glTF")) return Format::glb;
  if (head.starts_with("PK\x03\x04") && extension == "zip") return Format::zip;
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return Format::ply;
  if (sizes_as_binary_stl(bytes)) return Format::stl_binary;
  if (looks_like_ascii_stl(bytes)) return Format::stl_ascii;
  TextCursor text(bytes);
  const auto word = text.next_word();
  if (word == "OFF" || word == "COFF" || word == "NOFF" || word == "CNOFF" || word == "STOFF" ||
      word == "STCNOFF" || word == "4OFF" || word == "nOFF")
    return Format::off;
  if (looks_like_obj(bytes)) return Format::obj;
  if (kind_of_other_file(bytes).empty()) {
    if (extension == "stl") return Format::stl_binary;
    if (extension == "obj") return Format::obj;
  }
  return std::nullopt;
}

Result<ScanFile> read_as(Format format, Bytes bytes, const std::string& where, const ScanProgress& progress,
                         ScanParts parts) {
  switch (format) {
    case Format::stl_binary:
      return read_stl_binary(bytes, where, progress);
    case Format::stl_ascii:
      return read_stl_ascii(bytes, where, progress);
    case Format::obj:
      return read_obj(bytes, where, progress, parts);
    case Format::ply:
      return read_ply(bytes, where, progress, parts);
    case Format::off:
      return read_off(bytes, where, progress);
    case Format::glb:
      return read_glb(bytes, where, progress, parts);
    case Format::zip: {
      VACUFORM_TRY(files, read_model_zip(bytes, where, progress, parts));
      VACUFORM_TRY(scan, files.ply ? read_ply(files.model, where, progress, parts, &files)
                                   : read_obj(files.model, where, progress, parts, &files));
      scan.format += ", zipped";
      return scan;
    }
  }
  return fail(Code::internal, "a format without a reader", where);
}

}  // namespace

std::string text_mode_damage(Bytes bytes) {
  std::uint64_t replaced = 0, feeds = 0, returns_before = 0, high = 0, latin = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (bytes[i] >= 0x80) ++high;
    if (bytes[i] == '\n') ++feeds, returns_before += i > 0 && bytes[i - 1] == '\r';
    if (i + 2 < bytes.size() && bytes[i] == 0xEF && bytes[i + 1] == 0xBF && bytes[i + 2] == 0xBD) ++replaced;
    if (i + 1 < bytes.size() && (bytes[i] == 0xC2 || bytes[i] == 0xC3) && bytes[i + 1] >= 0x80 &&
        bytes[i + 1] < 0xC0)
      ++latin;
  }
  const std::string advice = "; it was destroyed by a text-mode copy and cannot be repaired";
  if (replaced >= 16 && 3 * replaced * 2 > high)
    return std::to_string(replaced) +
           " groups of bytes of the file were replaced by the mark for unreadable text (U+FFFD)" + advice;
  if (high >= 64 && latin * 2 == high) return "the file's bytes were turned from Latin-1 into UTF-8" + advice;
  if (feeds >= 16 && returns_before == feeds) return "every line feed of the file became CR LF" + advice;
  return {};
}

double crowding_of(const TriangleMesh& mesh) {
  const auto surface = [](const Eigen::AlignedBox3d& box) {
    const Eigen::Vector3d s = box.sizes();
    return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
  };
  Eigen::AlignedBox3d all;
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    Eigen::AlignedBox3d box;
    for (const int v : t) box.extend(mesh.vertices[v]);
    all.extend(box);
    sum += surface(box);
  }
  if (all.isEmpty()) return 0;
  const Eigen::Vector3d thick = all.sizes().cwiseMax(all.sizes().maxCoeff() / 3);
  return sum > 0 ? sum / surface({Eigen::Vector3d(0, 0, 0), thick}) : 0;
}

Result<ScanFile> read_scan(Bytes bytes, const std::string& file_name, const ScanProgress& progress,
                           ScanParts parts) {
  if (bytes.empty())
    return fail(Code::corrupt_file, "the scan file is empty", file_name, "upload or export it again");
  if (bytes.size() > scan_limits.bytes)
    return fail(Code::too_large,
                "the scan file has " + std::to_string(bytes.size()) + " bytes, above the limit of 1 GiB",
                file_name, "reduce the scan (quadric decimation) to a few hundred thousand triangles");
  bytes = without_mark(bytes);
  const auto format = recognise(bytes, extension_of(file_name));
  if (!format) {
    const auto kind = kind_of_other_file(bytes);
    return fail(Code::unsupported_format,
                kind.empty() ? "not a scan of a known format" : "the scan is " + std::string(kind), file_name,
                "give STL, OBJ, PLY, OFF or GLB, or a zip with an OBJ or PLY and its images");
  }
  VACUFORM_TRY(scan, read_as(*format, bytes, file_name, progress, parts));
  for (std::size_t i = 0; i < scan.mesh.vertices.size(); ++i) {
    const auto& p = scan.mesh.vertices[i];
    if (!p.allFinite())
      return corrupt("a coordinate of the scan is not a finite number",
                     file_name + ", vertex " + std::to_string(i + 1));
    if (p.cwiseAbs().maxCoeff() > scan_limits.coordinate)
      return corrupt("a coordinate of the scan is implausible, beyond 10,000,000",
                     file_name + ", vertex " + std::to_string(i + 1));
  }
  if (scan.mesh.triangles.empty())
    return fail(Code::unusable_scan,
                scan.mesh.vertices.empty() ? "the scan holds no triangles"
                                           : "the scan holds points but no triangles (a point cloud)",
                file_name, "export the surface as a mesh of triangles");
  if (crowding_of(scan.mesh) > scan_limits.crowding)
    return fail(Code::too_large,
                "too many triangles of the scan lie in the same place: long slivers, or copies of one body",
                file_name, "export one surface with triangles of about equal size (isotropic remeshing)");
  return scan;
}

}  // namespace vacuform
