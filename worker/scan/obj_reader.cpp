// Wavefront OBJ: `v` and `f` make the shape. Indices count from 1, or from the end when negative. Colours are the three
// numbers that may follow a vertex, encoded as sRGB, from 0 to 1 or from 0 to 255, and those of the MTL in the same
// zip.
#include <array>

#include "api/base/text.hpp"
#include "worker/scan/obj_colours.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {

Result<ScanFile> read_obj(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts, const ModelFiles* files) {
  ScanFile scan;
  scan.format = "OBJ";
  auto& [vertices, triangles] = scan.mesh;
  const bool coloured = parts == ScanParts::with_colours;
  ObjColours colours(files);
  if (coloured) VACUFORM_CHECK(colours.read_library(where));
  TextCursor text(bytes);
  std::string_view line;
  const auto at = [&] { return where + ", line " + std::to_string(text.line_number()); };
  std::int64_t largest = -1;  // vertices may follow the faces that name them
  std::string largest_at;
  bool names_library = false;
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
      if (coloured) colours.add_vertex(line, vertices.size());
      vertices.emplace_back(xyz[0], xyz[1], xyz[2]);
    } else if (word == "vt" && coloured && files) {
      VACUFORM_CHECK(colours.add_uv(line, at()));
    } else if (word.starts_with('#')) {
      if (scan.space == PatientSpace::unknown) scan.space = find_space(line).space;
    } else if (word == "mtllib") {
      names_library = true;
    } else if (word == "usemtl" && coloured) {
      colours.use(trimmed(line));
    } else if (word == "f") {
      std::int64_t first = 0, last = 0;
      std::array<std::int64_t, 3> uv{-1, -1, -1};
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
        uv[2] = coloured ? colours.uv_of(corner) : -1;
        if (corners == 0)
          first = index, uv[0] = uv[2];
        else if (corners > 1) {
          if (coloured) colours.add_triangle(uv);
          triangles.push_back({static_cast<int>(first), static_cast<int>(last), static_cast<int>(index)});
          if (triangles.size() > scan_limits.triangles) return too_many_triangles(triangles.size(), where);
        }
        last = index, uv[1] = uv[2];
        ++corners;
      }
    }
  }
  if (largest >= static_cast<std::int64_t>(vertices.size()))
    return corrupt("a face names vertex " + std::to_string(largest + 1) + ", but the file has " +
                       std::to_string(vertices.size()),
                   largest_at);
  if (!coloured) return scan;
  VACUFORM_TRY(of_file, colours.take(scan.mesh, where));
  scan.colours = std::move(of_file);
  scan.colour_notes = colours.notes();
  scan.colours_missing = colours.missing();
  if (names_library && (!files || files->library.empty()))
    scan.colours_missing.push_back("The OBJ names a material library (mtllib), but its MTL was not given");
  return scan;
}

}  // namespace vacuform
