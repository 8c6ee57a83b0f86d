#include "worker/surface/stl.hpp"

#include <bit>
#include <cstring>

namespace vacuform {

std::vector<std::uint8_t> stl_bytes(const TriangleMesh& mesh) {
  constexpr char header[] = "Vacuform mold, mm";
  std::vector<std::uint8_t> bytes(80, 0);
  std::memcpy(bytes.data(), header, sizeof header - 1);
  bytes.reserve(84 + 50 * mesh.triangles.size());
  const auto put32 = [&](std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  };
  const auto put_point = [&](const Eigen::Vector3d& p) {
    for (int k = 0; k < 3; ++k) put32(std::bit_cast<std::uint32_t>(static_cast<float>(p[k])));
  };
  put32(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    put_point(area_vector(mesh, t).normalized());
    for (const int v : t) put_point(mesh.vertices[v]);
    bytes.push_back(0);
    bytes.push_back(0);
  }
  return bytes;
}

}  // namespace vacuform
