#include "worker/inspection/mesh_files.hpp"

#include <bit>
#include <cstring>
#include <string>

#include "worker/decimal.hpp"

namespace vacuform {
namespace {

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

void append(std::vector<std::uint8_t>& out, std::uint32_t bits) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(bits >> shift));
}
void append(std::vector<std::uint8_t>& out, double value) {
  append(out, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

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
  std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment Vacuform formed sheet, mm, degrees Celsius\n";
  header += "element vertex " + std::to_string(sheet.formed.size()) + "\n";
  for (const char* property : {"x", "y", "z", "s", "t", "u", "v", "thickness", "temperature"})
    header += std::string("property float ") + property + "\n";
  header += "property uchar contact\nelement face " + std::to_string(sheet.triangles.size()) +
            "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<std::uint8_t> out = bytes_of(header);
  out.reserve(out.size() + 37 * sheet.formed.size() + 13 * sheet.triangles.size());
  for (std::size_t i = 0; i < sheet.formed.size(); ++i) {
    for (int k = 0; k < 3; ++k) append(out, sheet.formed[i][k]);
    for (int k = 0; k < 2; ++k) append(out, sheet.rest[i][k]);
    for (int k = 0; k < 2; ++k) append(out, job.print.pattern_uv[i][k]);
    append(out, sheet.thickness[i]);
    append(out, sheet.temperature[i]);
    out.push_back(static_cast<std::uint8_t>(sheet.contact[i]));
  }
  for (const auto& t : sheet.triangles) {
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
  const Eigen::Vector2d size = job.pattern.size_mm();
  std::string out = "# Vacuform formed surface under the pattern, mm; the pattern is the texture\n", textures;
  std::vector<int> number(job.sheet.formed.size(), 0);
  for (const int t : job.flattening.triangles)
    for (const int v : job.sheet.triangles[static_cast<std::size_t>(t)])
      number[static_cast<std::size_t>(v)] = 1;
  int used = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (!number[i]) continue;
    number[i] = ++used;
    append_vertex(out, job.sheet.formed[i]);
    append_texture(textures, job.print.pattern_uv[i].cwiseQuotient(size) + Eigen::Vector2d(0.5, 0.5));
  }
  out += textures;
  for (const int t : job.flattening.triangles) {
    const auto& c = job.sheet.triangles[static_cast<std::size_t>(t)];
    append_face(out, number[static_cast<std::size_t>(c[0])], number[static_cast<std::size_t>(c[1])],
                number[static_cast<std::size_t>(c[2])]);
  }
  return bytes_of(out);
}

}  // namespace vacuform
