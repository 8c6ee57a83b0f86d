#include "worker/inspection/mesh_files.hpp"

#include <string>

#include "api/base/decimal.hpp"
#include "worker/gltf/little_endian.hpp"
#include "worker/inspection/unfolded_sheet.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

void append_vertex(std::string& out, const Eigen::Vector3d& p) {
  out += "v " + decimal(p.x(), 5) + ' ' + decimal(p.y(), 5) + ' ' + decimal(p.z(), 5) + '\n';
}
void append_texture(std::string& out, const Eigen::Vector2d& p) {
  out += "vt " + decimal(p.x(), 7) + ' ' + decimal(p.y(), 7) + '\n';
}
// Corners that use the same number for the place and the texture, counted from 1.
void append_face(std::string& out, int a, int b, int c) {
  out += 'f';
  for (const int v : {a, b, c}) {
    const std::string number = std::to_string(v);
    out += ' ' + number + '/' + number;
  }
  out += '\n';
}

}  // namespace

std::vector<std::uint8_t> formed_ply(const Finished& job) {
  const FormedSheet& sheet = job.sheet;
  const Unfolded all = unfolded(job);
  std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment Vacuform formed sheet, mm, degrees Celsius\n";
  if (all.vertex.size() > sheet.formed.size())
    header += "comment vertices from " + std::to_string(sheet.formed.size()) +
              " on are earlier ones again, with the pattern coordinates of another segment\n";
  header += "element vertex " + std::to_string(all.vertex.size()) + "\n";
  for (const char* property : {"x", "y", "z", "s", "t", "u", "v", "thickness", "temperature"})
    header += std::string("property float ") + property + "\n";
  header += "property uchar contact\nelement face " + std::to_string(sheet.triangles.size()) +
            "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<std::uint8_t> out = bytes_of(header);
  out.reserve(out.size() + 37 * all.vertex.size() + 13 * sheet.triangles.size());
  for (std::size_t j = 0; j < all.vertex.size(); ++j) {
    const auto i = static_cast<std::size_t>(all.vertex[j]);
    for (int k = 0; k < 3; ++k) append(out, sheet.formed[i][k]);
    for (int k = 0; k < 2; ++k) append(out, sheet.rest[i][k]);
    for (int k = 0; k < 2; ++k) append(out, all.uv[j][k]);
    append(out, sheet.thickness[i]);
    append(out, sheet.temperature[i]);
    out.push_back(static_cast<std::uint8_t>(sheet.contact[i]));
  }
  for (const auto& t : all.corners) {
    out.push_back(3);
    for (const int v : t) append(out, static_cast<std::uint32_t>(v));
  }
  return out;
}

std::vector<std::uint8_t> formed_obj(const Finished& job) {
  std::string out = "# Vacuform formed sheet, mm\nmtllib formed.mtl\n";
  for (const auto& p : job.sheet.formed) append_vertex(out, p);
  for (const auto& st : job.sheet.rest) append_texture(out, job.print.picture_uv(st));
  out += "usemtl print\n";
  for (const auto& t : job.sheet.triangles) append_face(out, t[0] + 1, t[1] + 1, t[2] + 1);
  return bytes_of(out);
}

std::vector<std::uint8_t> formed_mtl() {
  return bytes_of("newmtl print\nKa 1 1 1\nKd 1 1 1\nKs 0.1 0.1 0.1\nNs 30\nillum 2\nmap_Kd print.png\n");
}

std::vector<std::uint8_t> uv_map_obj(const Finished& job) {
  const Vector2d size = job.pattern.size_mm();
  const Unfolded all = textured(job);
  std::string out = "# Vacuform formed surface under the pattern, mm; the pattern is the texture\n", textures;
  std::vector<int> number(all.vertex.size(), 0);
  int used = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (all.uv[i].hasNaN()) continue;
    number[i] = ++used;
    append_vertex(out, job.sheet.formed[all.vertex[i]]);
    append_texture(textures, all.uv[i].cwiseQuotient(size) + Vector2d(0.5, 0.5));
  }
  out += textures;
  for (const int t : job.flattening.triangles) {
    const auto& c = all.corners[t];
    append_face(out, number[c[0]], number[c[1]], number[c[2]]);
  }
  return bytes_of(out);
}

}  // namespace vacuform
