#include "worker/flattening/outside.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

namespace vacuform {

std::vector<Triangle> triangles_outside(const std::vector<Eigen::Vector2d>& points,
                                        const std::vector<std::vector<int>>& loops,
                                        const std::vector<int>& around) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Vertex = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;  // its index in points
  using Face = CGAL::Triangulation_face_base_with_info_2<int, Kernel,
                                                         CGAL::Constrained_triangulation_face_base_2<Kernel>>;
  using Triangulation =
      CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;
  Triangulation plane;
  const auto insert = [&](int i) {
    const auto vertex = plane.insert(Kernel::Point_2(points[i].x(), points[i].y()));
    vertex->info() = i;
    return vertex;
  };
  for (const auto& loop : loops) {
    const auto first = insert(loop.front());
    auto last = first;
    for (std::size_t i = 1; i < loop.size(); ++i) {
      const auto next = insert(loop[i]);
      plane.insert_constraint(last, next);
      last = next;
    }
    plane.insert_constraint(last, first);
  }
  for (const int i : around) insert(i);

  // How many border lines lie between a face and infinity; the chart is where that is odd.
  constexpr int unknown = -1;
  for (auto f = plane.all_faces_begin(); f != plane.all_faces_end(); ++f) f->info() = unknown;
  std::vector<Triangulation::Face_handle> ring{plane.infinite_face()}, next;
  for (int level = 0; !ring.empty(); ++level, ring.swap(next), next.clear())
    while (!ring.empty()) {
      const auto face = ring.back();
      ring.pop_back();
      if (face->info() != unknown) continue;
      face->info() = level;
      for (int e = 0; e < 3; ++e)
        if (const auto other = face->neighbor(e); other->info() == unknown)
          (plane.is_constrained({face, e}) ? next : ring).push_back(other);
    }

  std::vector<Triangle> outside;
  for (auto f = plane.finite_faces_begin(); f != plane.finite_faces_end(); ++f)
    if (f->info() % 2 == 0)
      outside.push_back({f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()});
  return outside;
}

}  // namespace vacuform
