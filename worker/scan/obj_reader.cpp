// Wavefront OBJ: only `v` and `f` matter here. Indices count from 1, or from the end when negative.
#include "worker/scan/scan_file.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {

Result<ScanFile> read_obj(Bytes bytes, const std::string& where, const ScanProgress& progress) {
  ScanFile scan;
  scan.format = "OBJ";
  auto& [vertices, triangles] = scan.mesh;
  TextCursor text(bytes);
  std::string_view line;
  const auto at = [&] { return where + ", line " + std::to_string(text.line_number()); };
  std::int64_t largest = -1;  // vertices may follow the faces that name them
  std::string largest_at;
  while (text.next_line(line)) {
    if (text.line_number() % 65536 == 0) VACUFORM_CHECK(progress.tick());
    const auto word = take_word(line);
    if (word == "v") {
      double xyz[3];
      for (double& x : xyz)
        if (!parse_number(take_word(line), x)) return corrupt("a vertex does not have three numbers", at());
      if (vertices.size() >= scan_limits.vertices)
        return fail(Code::too_large,
                    "the scan has more than " + std::to_string(scan_limits.vertices) + " vertices", where,
                    "reduce it (quadric decimation) to a few hundred thousand triangles");
      vertices.emplace_back(xyz[0], xyz[1], xyz[2]);
    } else if (word == "f") {
      std::int64_t first = 0, last = 0;
      int corners = 0;
      while (true) {
        auto corner = take_word(line);
        if (corner == "\\") {  // the face continues in the next line
          if (!text.next_line(line)) break;
          continue;
        }
        if (corner.empty() || corner.front() == '#') break;
        std::int64_t index = 0;
        if (!parse_integer(corner.substr(0, corner.find('/')), index) || index == 0)
          return corrupt("\"" + std::string(corner.substr(0, 40)) + "\" is not a corner of a face", at());
        const auto count = static_cast<std::int64_t>(vertices.size());
        index = index < 0 ? count + index : index - 1;
        if (index < 0 || index >= static_cast<std::int64_t>(scan_limits.vertices))
          return corrupt("a face names vertex " +
                             std::string(corner.substr(0, corner.find('/')).substr(0, 40)) +
                             ", but there are " + std::to_string(count) + " so far",
                         at());
        if (index > largest) largest = index, largest_at = index >= count ? at() : std::string();
        if (corners == 0)
          first = index;
        else if (corners > 1) {
          triangles.push_back({static_cast<int>(first), static_cast<int>(last), static_cast<int>(index)});
          if (triangles.size() > scan_limits.triangles) return too_many_triangles(triangles.size(), where);
        }
        last = index;
        ++corners;
      }
    }
  }
  if (largest >= static_cast<std::int64_t>(vertices.size()))
    return corrupt("a face names vertex " + std::to_string(largest + 1) + ", but the file has " +
                       std::to_string(vertices.size()),
                   largest_at);
  return scan;
}

}  // namespace vacuform
