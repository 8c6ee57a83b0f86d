// Object File Format: a header word (OFF, with C, N or ST before it for what each vertex carries besides), counts, one
// line for each vertex and one for each face. Colours and normals after the coordinates or the corners on a line are
// ignored.
#include <algorithm>

#include "worker/scan/scan_file.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {

Result<ScanFile> read_off(Bytes bytes, const std::string& where, const ScanProgress& progress) {
  ScanFile scan;
  scan.format = "OFF";
  auto& [vertices, triangles] = scan.mesh;
  TextCursor text(bytes);
  std::string_view line;
  const auto at = [&] { return where + ", line " + std::to_string(text.line_number()); };
  // The next line that is not empty, without its comment.
  const auto next = [&] {
    while (text.next_line(line)) {
      line = line.substr(0, line.find('#'));
      if (std::any_of(line.begin(), line.end(), [](char c) { return !TextCursor::is_space(c); })) return true;
    }
    return false;
  };

  if (!next()) return corrupt("the OFF file is empty", where);
  const auto header = take_word(line);
  if (header.find('4') != header.npos || header.find('n') != header.npos)
    return fail(Code::unsupported_format,
                "an OFF file of another dimension than three (" + std::string(header.substr(0, 16)) + ")",
                where, "export the scan as STL, OBJ or PLY");
  auto rest = line;
  if (take_word(rest) == "BINARY")
    return fail(Code::unsupported_format, "a binary OFF file", where, "export the scan as STL, OBJ or PLY");
  rest = line;
  if (take_word(rest).empty() && !next()) return corrupt("the OFF file ends after its first line", where);
  std::int64_t vertex_count = 0, face_count = 0;
  if (!parse_integer(take_word(line), vertex_count) || !parse_integer(take_word(line), face_count) ||
      vertex_count < 0 || face_count < 0)
    return corrupt("the OFF file does not say how many vertices and faces it has", at());
  // A vertex takes at least "0 0 0" and a line end, a face "1 0": counts that need more bytes than there are must be
  // false.
  const std::uint64_t left = text.remaining() + 1;
  if (static_cast<std::uint64_t>(vertex_count) > left / 6 ||
      static_cast<std::uint64_t>(face_count) > left / 4)
    return corrupt("the OFF file says it has " + std::to_string(vertex_count) + " vertices and " +
                       std::to_string(face_count) + " faces, but only " + std::to_string(left - 1) +
                       " bytes follow",
                   at());
  if (static_cast<std::uint64_t>(vertex_count) > scan_limits.vertices)
    return fail(Code::too_large, "the scan has " + std::to_string(vertex_count) + " vertices", where,
                "reduce it (quadric decimation) to a few hundred thousand triangles");

  vertices.reserve(static_cast<std::size_t>(vertex_count));
  for (std::int64_t i = 0; i < vertex_count; ++i) {
    if (i % 65536 == 0) VACUFORM_CHECK(progress.tick());
    if (!next())
      return corrupt(
          "the file ends after " + std::to_string(i) + " of " + std::to_string(vertex_count) + " vertices",
          at());
    double xyz[3];
    for (double& x : xyz)
      if (!parse_number(take_word(line), x)) return corrupt("a vertex does not have three numbers", at());
    vertices.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  for (std::int64_t i = 0; i < face_count; ++i) {
    if (i % 65536 == 0) VACUFORM_CHECK(progress.tick());
    if (!next())
      return corrupt(
          "the file ends after " + std::to_string(i) + " of " + std::to_string(face_count) + " faces", at());
    std::int64_t corners = 0, first = 0, last = 0;
    if (!parse_integer(take_word(line), corners) || corners < 0)
      return corrupt("a face does not say how many corners it has", at());
    for (std::int64_t k = 0; k < corners; ++k) {
      std::int64_t index = 0;
      const auto word = take_word(line);
      if (!parse_integer(word, index)) return corrupt("a face has fewer corners than it says", at());
      if (index < 0 || index >= vertex_count)
        return corrupt("a face names vertex " + std::to_string(index) + ", but the vertices are 0 to " +
                           std::to_string(vertex_count - 1),
                       at());
      if (k == 0)
        first = index;
      else if (k > 1)
        triangles.push_back({static_cast<int>(first), static_cast<int>(last), static_cast<int>(index)});
      last = index;
    }
    if (triangles.size() > scan_limits.triangles) return too_many_triangles(triangles.size(), where);
  }
  return scan;
}

}  // namespace vacuform
