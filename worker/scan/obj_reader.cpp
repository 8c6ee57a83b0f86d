// Wavefront OBJ: `v` and `f` make the shape. Indices count from 1, or from the end when negative. Colours are the three
// numbers that may follow a vertex, encoded as sRGB, from 0 to 1 or from 0 to 255.
#include <algorithm>
#include <cmath>

#include "worker/scan/scan_file.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {

namespace {

// The colours that follow vertices, as the file has them.
class ObjVertexColours {
 public:
  // The rest of the line of vertex `index`.
  void take(std::string_view rest, std::size_t index) {
    double rgb[3];
    for (double& x : rgb)
      if (!parse_number(take_word(rest), x) || !std::isfinite(x)) return;  // none, or the weight of a curve
    given_.resize(index, Eigen::Vector3f(-1, -1, -1));
    given_.emplace_back(static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]));
  }
  std::optional<ScanColours> colours(const TriangleMesh& mesh) {
    if (given_.empty()) return std::nullopt;
    given_.resize(mesh.vertices.size(), Eigen::Vector3f(-1, -1, -1));
    float largest = 0;
    for (const auto& rgb : given_) largest = std::max(largest, rgb.maxCoeff());
    const float scale = largest > 1 ? 255.0f : 1.0f;
    for (auto& rgb : given_)
      rgb = rgb.minCoeff() < 0 ? Eigen::Vector3f(1, 1, 1)
                               : Eigen::Vector3f((rgb / scale).unaryExpr(&linear_from_srgb));
    ScanColours out;
    out.materials.emplace_back();
    out.material.assign(mesh.triangles.size(), 0);
    out.vertex = std::move(given_);
    return out;
  }

 private:
  std::vector<Eigen::Vector3f> given_;  // negative: none
};

}  // namespace

Result<ScanFile> read_obj(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts) {
  ScanFile scan;
  scan.format = "OBJ";
  auto& [vertices, triangles] = scan.mesh;
  ObjVertexColours colours;
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
      if (parts == ScanParts::with_colours) colours.take(line, vertices.size());
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
  scan.colours = colours.colours(scan.mesh);
  return scan;
}

}  // namespace vacuform
