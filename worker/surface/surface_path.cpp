#include "worker/surface/surface_path.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <algorithm>
#include <array>
#include <unordered_map>

namespace vacuform {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Traits = CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>;
using Paths = CGAL::Surface_mesh_shortest_path<Traits>;

// What the path visits, from its target to its source.
struct Visits {
  const Mesh& mesh;
  const std::vector<int>& numbers;  // of the mesh's vertices, ours
  std::vector<PathPoint>& out;

  int number(Mesh::Vertex_index v) const { return numbers[static_cast<std::size_t>(v)]; }
  void operator()(Mesh::Halfedge_index edge, Kernel::FT along) {
    out.push_back({number(mesh.source(edge)), number(mesh.target(edge)), std::clamp(along, 0.0, 1.0)});
  }
  void operator()(Mesh::Vertex_index v) { out.push_back({number(v), number(v), 0}); }
  void operator()(Mesh::Face_index, const Traits::Barycentric_coordinates&) {}  // both ends are vertices
};

}  // namespace

std::vector<PathPoint> shortest_path(const std::vector<Triangle>& triangles,
                                     const std::vector<Eigen::Vector3d>& surface,
                                     const std::vector<int>& which, int from, int to) {
  Mesh mesh;
  std::vector<int> numbers;
  std::unordered_map<int, Mesh::Vertex_index> vertices;  // looked up only
  for (const int t : which) {
    std::array<Mesh::Vertex_index, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const int v = triangles[static_cast<std::size_t>(t)][k];
      const auto [found, is_new] = vertices.try_emplace(v);
      if (is_new) {
        const Eigen::Vector3d& p = surface[static_cast<std::size_t>(v)];
        found->second = mesh.add_vertex({p.x(), p.y(), p.z()});
        numbers.push_back(v);
      }
      corners[k] = found->second;
    }
    mesh.add_face(corners[0], corners[1], corners[2]);
  }
  std::vector<PathPoint> out;
  const auto source = vertices.find(from), target = vertices.find(to);
  if (source == vertices.end() || target == vertices.end()) return out;
  Paths paths(mesh);
  paths.add_source_point(source->second);
  Visits visits{mesh, numbers, out};
  const auto found = paths.shortest_path_sequence_to_source_points(target->second, visits);
  if (found.second == paths.source_points_end() || !(found.first >= 0)) return {};
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace vacuform
