// The only use of CGAL's constrained Delaunay triangulation.
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include "worker/scan/cutting.hpp"

namespace vacuform {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<int, Kernel,
                                              CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::No_constraint_intersection_tag>;

}  // namespace

std::optional<std::vector<Triangle>> flat_cap(const std::vector<Eigen::Vector3d>& vertices,
                                              const std::vector<std::vector<int>>& loops) {
  Triangulation triangulation;
  try {
    for (const auto& loop : loops) {
      std::vector<Triangulation::Vertex_handle> handles;
      for (const int v : loop) {
        const auto& p = vertices[v];
        const auto before = triangulation.number_of_vertices();
        handles.push_back(triangulation.insert({p.x(), p.y()}));
        if (triangulation.number_of_vertices() == before) return std::nullopt;  // two vertices at one place
        handles.back()->info() = v;
      }
      for (std::size_t i = 0; i < handles.size(); ++i)
        triangulation.insert_constraint(handles[i], handles[(i + 1) % handles.size()]);
    }
  } catch (const Triangulation::Intersection_of_constraints_exception&) {
    return std::nullopt;
  }
  if (triangulation.dimension() < 2) return std::nullopt;

  // From outside inwards: the level rises by one at each outline.
  for (auto face = triangulation.all_faces_begin(); face != triangulation.all_faces_end(); ++face)
    face->info() = -1;
  std::vector<Triangulation::Face_handle> level{triangulation.infinite_face()}, next;
  for (int depth = 0; !level.empty(); ++depth, level.swap(next)) {
    next.clear();
    while (!level.empty()) {
      const auto face = level.back();
      level.pop_back();
      if (face->info() >= 0) continue;
      face->info() = depth;
      for (int k = 0; k < 3; ++k) {
        const auto neighbour = face->neighbor(k);
        if (neighbour->info() < 0)
          (triangulation.is_constrained({face, k}) ? next : level).push_back(neighbour);
      }
    }
  }
  std::vector<Triangle> triangles;
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end(); ++face)
    if (face->info() % 2 == 1)  // turned over: the cap faces down
      triangles.push_back({face->vertex(0)->info(), face->vertex(2)->info(), face->vertex(1)->info()});
  return triangles;
}

}  // namespace vacuform
