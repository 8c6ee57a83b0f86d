// STL, binary and ASCII. A binary file is 80 bytes of anything (often "solid ..."), a 32-bit count and 50
// bytes a triangle; the stored normals are often wrong and are ignored.
#include <bit>
#include <cstring>

#include "worker/scan/scan_file.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {
namespace {

constexpr std::uint64_t header_bytes = 84, record_bytes = 50;

float little_endian_float(const std::uint8_t* p) {
  const std::uint32_t bits =
      std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16 | std::uint32_t{p[3]} << 24;
  return std::bit_cast<float>(bits);
}

}  // namespace

Result<ScanFile> read_stl_binary(Bytes bytes, const std::string& where, const ScanProgress& progress) {
  if (bytes.size() < header_bytes)
    return corrupt("the binary STL file ends within its header of 84 bytes", where);
  const std::uint64_t count = std::uint64_t{bytes[80]} | std::uint64_t{bytes[81]} << 8 |
                              std::uint64_t{bytes[82]} << 16 | std::uint64_t{bytes[83]} << 24;
  const std::uint64_t needed = header_bytes + record_bytes * count;
  if (needed > bytes.size()) {
    const std::string damage = text_mode_damage(bytes);
    if (!damage.empty()) return corrupt(damage, where);
    return corrupt("the binary STL file says it has " + std::to_string(count) + " triangles, which take " +
                       std::to_string(needed) + " bytes, but it has " + std::to_string(bytes.size()) +
                       " bytes",
                   where);
  }
  if (count > scan_limits.triangles) return too_many_triangles(count, where);
  ScanFile scan;
  scan.format = "STL (binary)";
  scan.mesh.vertices.reserve(3 * count);
  scan.mesh.triangles.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    if (i % 262144 == 0) VACUFORM_CHECK(progress.tick());
    const std::uint8_t* record = bytes.data() + header_bytes + record_bytes * i + 12;
    const int first = static_cast<int>(3 * i);
    for (int corner = 0; corner < 3; ++corner, record += 12)
      scan.mesh.vertices.emplace_back(little_endian_float(record), little_endian_float(record + 4),
                                      little_endian_float(record + 8));
    scan.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return scan;
}

Result<ScanFile> read_stl_ascii(Bytes bytes, const std::string& where, const ScanProgress& progress) {
  ScanFile scan;
  scan.format = "STL (ASCII)";
  auto& vertices = scan.mesh.vertices;
  TextCursor text(bytes);
  std::string_view line;
  std::uint64_t corners = 0, facets = 0;
  bool in_facet = false;
  const auto at = [&] { return where + ", line " + std::to_string(text.line_number()); };
  while (text.next_line(line)) {
    if (text.line_number() % 65536 == 0) VACUFORM_CHECK(progress.tick());
    const auto word = take_word(line);
    if (word == "facet") {
      if (in_facet) return corrupt("a facet begins before the last one ended", at());
      in_facet = true;
      corners = 0;
    } else if (word == "vertex") {
      double xyz[3];
      for (double& x : xyz)
        if (!parse_number(take_word(line), x)) return corrupt("a vertex does not have three numbers", at());
      if (!in_facet || ++corners > 3) return corrupt("a vertex stands outside of a facet of three", at());
      vertices.emplace_back(xyz[0], xyz[1], xyz[2]);
    } else if (word == "endfacet") {
      if (!in_facet || corners != 3) return corrupt("a facet does not have three vertices", at());
      in_facet = false;
      if (++facets > scan_limits.triangles) return too_many_triangles(facets, where);
      const int last = static_cast<int>(vertices.size());
      scan.mesh.triangles.push_back({last - 3, last - 2, last - 1});
    } else if (word != "outer" && word != "endloop" && word != "solid" && word != "endsolid" &&
               !word.empty()) {
      // Only "solid" may be followed by free text; some exporters let its name run over several lines.
      if (facets > 0 || in_facet)
        return corrupt("\"" + std::string(word.substr(0, 40)) + "\" is not a keyword of ASCII STL", at());
    }
  }
  if (in_facet) return corrupt("the file ends within a facet", at());
  return scan;
}

}  // namespace vacuform
