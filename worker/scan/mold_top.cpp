#include "worker/scan/mold_top.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "worker/numerics/plane.hpp"
#include "worker/scan/topology.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Of the section below the highest vertex, as a share of the mesh's diagonal. More than a flat face is uneven by the
// rounding of a file, or by 0.01 mm after a new skin with a clearance of 1 mm; too little for a dome to be cut off
// unevenly.
constexpr double section_depth = 2e-4;

// Seen from above, the signed areas of a closed surface above a plane add up to its section with the plane.
struct SectionPiece {
  double area = 0;
  Vector2d moment{0, 0};

  // Takes the part of a triangle with z >= 0.
  void add(const std::array<Vector3d, 3>& corners) {
    std::array<Vector2d, 4> polygon;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d &a = corners[k], &b = corners[(k + 1) % 3];
      if (a.z() >= 0) polygon[count++] = a.head<2>();
      if ((a.z() >= 0) != (b.z() >= 0)) polygon[count++] = (a + a.z() / (a.z() - b.z()) * (b - a)).head<2>();
    }
    for (std::size_t k = 1; k + 1 < count; ++k) {
      const double part = cross(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]) / 2;
      area += part;
      moment += part / 3 * (polygon[0] + polygon[k] + polygon[k + 1]);
    }
  }
  Vector2d centroid() const { return moment / area; }
};

// Numbers the vertices above the height by the first vertex that they are connected to there; the others keep their own.
std::vector<int> connected_above(const TriangleMesh& mesh, double height) {
  std::vector<int> first(mesh.vertices.size());
  std::iota(first.begin(), first.end(), 0);
  const auto root = [&](int v) {
    while (first[index(v)] != v) v = first[index(v)] = first[index(first[index(v)])];
    return v;
  };
  const auto above = [&](int v) { return mesh.vertices[index(v)].z() >= height; };
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (!above(a) || !above(b)) continue;
      const int one = root(a), other = root(b);
      first[index(std::max(one, other))] = std::min(one, other);
    }
  for (std::size_t v = 0; v < first.size(); ++v) first[v] = root(static_cast<int>(v));
  return first;
}

}  // namespace

Vector3d top_of(const TriangleMesh& mesh) {
  const Vector3d highest =
      *std::max_element(mesh.vertices.begin(), mesh.vertices.end(),
                        [](const Vector3d& a, const Vector3d& b) { return a.z() < b.z(); });
  const double height = highest.z() - section_depth * bounds(mesh).size().norm();
  const std::vector<int> first = connected_above(mesh, height);
  const Vector3d origin(highest.x(), highest.y(), height);  // near the section, for accuracy
  std::vector<SectionPiece> pieces(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    const auto above =
        std::find_if(t.begin(), t.end(), [&](int v) { return mesh.vertices[index(v)].z() >= height; });
    if (above == t.end()) continue;
    pieces[index(first[index(*above)])].add({mesh.vertices[index(t[0])] - origin,
                                             mesh.vertices[index(t[1])] - origin,
                                             mesh.vertices[index(t[2])] - origin});
  }
  double largest = 0;
  for (const SectionPiece& piece : pieces) largest = std::max(largest, piece.area);
  if (!(largest > 0)) return highest;
  constexpr double as_large = 0.999;
  Vector2d best = Vector2d::Constant(HUGE_VAL);
  for (const SectionPiece& piece : pieces) {
    if (!(piece.area >= as_large * largest)) continue;
    const Vector2d centre = highest.head<2>() + piece.centroid();
    if (centre.squaredNorm() < best.squaredNorm()) best = centre;
  }
  return {best.x(), best.y(), highest.z()};
}

}  // namespace vacuform
