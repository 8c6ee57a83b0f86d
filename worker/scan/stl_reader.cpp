// STL, binary and ASCII. A binary file is 80 bytes of anything (often "solid ..."), a 32-bit count and 50
// bytes a triangle; the stored normals are often wrong and are ignored. The count is often wrong, too: the size of the
// file decides (api/base/stl_bodies.hpp). Keywords of ASCII files are in any case, and "end solid" is "endsolid".
#include <bit>

#include "api/base/stl_bodies.hpp"
#include "api/base/text.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {
namespace {

constexpr std::size_t longest_keyword = 16;

float little_endian_float(const std::uint8_t* p) {
  const std::uint32_t bits =
      std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16 | std::uint32_t{p[3]} << 24;
  return std::bit_cast<float>(bits);
}

}  // namespace

Result<ScanFile> read_stl_binary(Bytes bytes, const std::string& where, const ScanProgress& progress) {
  if (bytes.size() < stl_head_bytes)
    return corrupt("the binary STL file ends within its header of 84 bytes", where);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  VACUFORM_TRY(found, find_stl_bodies(MemorySource(text)));
  const std::uint64_t count = found.triangles();
  if (found.bodies.front().end() > bytes.size()) {
    const std::string damage = text_mode_damage(bytes);
    if (!damage.empty()) return corrupt(damage, where);
    return corrupt("the binary STL file says it has " + std::to_string(count) + " triangles, which take " +
                       std::to_string(found.bodies.front().end()) + " bytes, but it has " +
                       std::to_string(bytes.size()) + " bytes",
                   where);
  }
  if (found.rest == StlBodies::Rest::unknown)
    return corrupt("the binary STL file says it has " + std::to_string(found.declared) + " triangles, but " +
                       std::to_string(found.rest_bytes) +
                       " bytes follow its triangles that are neither triangles nor another body",
                   where);
  if (count > scan_limits.triangles) return too_many_triangles(count, where);
  ScanFile scan;
  scan.format = "STL (binary)";
  scan.space = find_space(text.substr(0, 80)).space;
  if (found.by_size())
    scan.notes.push_back(
        "The head of the STL file counts " + std::to_string(found.declared) +
        " triangles, but the file has " + std::to_string(count) +
        (found.bodies.size() > 1 ? " in " + std::to_string(found.bodies.size()) + " bodies" : std::string()) +
        "; all of them are read");
  scan.mesh.vertices.reserve(3 * count);
  scan.mesh.triangles.reserve(count);
  for (const StlBodies::Body& body : found.bodies)
    for (std::uint64_t i = 0; i < body.triangles; ++i) {
      if (i % 262144 == 0) VACUFORM_CHECK(progress.tick());
      const std::uint8_t* record = bytes.data() + body.begin + stl_head_bytes + stl_record_bytes * i + 12;
      const int first = static_cast<int>(scan.mesh.vertices.size());
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
    const auto written = take_word(line);
    std::string word = lower(written.substr(0, longest_keyword));
    if (word == "end") word += lower(take_word(line).substr(0, longest_keyword));
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
    } else if (word == "solid") {
      if (scan.space == PatientSpace::unknown) scan.space = find_space(line).space;
    } else if (word != "outer" && word != "endloop" && word != "endsolid" && !word.empty()) {
      // Only "solid" may be followed by free text; some exporters let its name run over several lines.
      if (facets > 0 || in_facet)
        return corrupt("\"" + std::string(written.substr(0, 40)) + "\" is not a keyword of ASCII STL", at());
    }
  }
  if (in_facet) return corrupt("the file ends within a facet", at());
  return scan;
}

}  // namespace vacuform
