#include "worker/inspection/mesh_files.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>

#include "api/base/decimal.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

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

// The formed sheet's corners with pattern coordinates: a vertex where several charts meet is there once for each of the
// coordinates that it has, the first under its own number and the others after all vertices.
struct Unfolded {
  std::vector<int> vertex;        // of the sheet
  std::vector<Vector2d> uv;       // NaN off the charts
  std::vector<Triangle> corners;  // of all triangles of the sheet
};
Unfolded unfolded(const Finished& job) {
  const std::size_t count = job.sheet.formed.size();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Unfolded out{std::vector<int>(count), std::vector<Vector2d>(count, Vector2d(nan, nan)),
               job.sheet.triangles};
  std::iota(out.vertex.begin(), out.vertex.end(), 0);
  std::vector<std::vector<int>> more(count);  // further copies of each vertex
  for (std::size_t i = 0; i < job.flattening.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      int& v = out.corners[static_cast<std::size_t>(job.flattening.triangles[i])][k];
      const auto first = static_cast<std::size_t>(v);
      const Vector2d& uv = job.print.pattern_uv[i][k];
      const auto is_it = [&](int copy) { return out.uv[static_cast<std::size_t>(copy)] == uv; };
      if (out.uv[first].hasNaN()) out.uv[first] = uv;
      if (is_it(v)) continue;
      auto copy = std::find_if(more[first].begin(), more[first].end(), is_it);
      if (copy == more[first].end()) {
        copy = more[first].insert(copy, static_cast<int>(out.vertex.size()));
        out.vertex.push_back(v);
        out.uv.push_back(uv);
      }
      v = *copy;
    }
  return out;
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
  const Unfolded all = unfolded(job);
  std::string out = "# Vacuform formed surface under the pattern, mm; the pattern is the texture\n", textures;
  std::vector<int> number(all.vertex.size(), 0);
  int used = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (all.uv[i].hasNaN()) continue;
    number[i] = ++used;
    append_vertex(out, job.sheet.formed[static_cast<std::size_t>(all.vertex[i])]);
    append_texture(textures, all.uv[i].cwiseQuotient(size) + Vector2d(0.5, 0.5));
  }
  out += textures;
  for (const int t : job.flattening.triangles) {
    const auto& c = all.corners[static_cast<std::size_t>(t)];
    append_face(out, number[static_cast<std::size_t>(c[0])], number[static_cast<std::size_t>(c[1])],
                number[static_cast<std::size_t>(c[2])]);
  }
  return bytes_of(out);
}

}  // namespace vacuform
