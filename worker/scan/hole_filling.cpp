// The only use of CGAL's hole filling.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <iterator>

#include "worker/scan/closing.hpp"

namespace vacuform {

std::vector<Triangle> fill_hole(const std::vector<Eigen::Vector3d>& vertices, const std::vector<int>& loop) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  if (loop.size() == 3) return {{loop[0], loop[1], loop[2]}};
  std::vector<Kernel::Point_3> line;
  line.reserve(loop.size());
  for (const int v : loop) {
    const auto& p = vertices[v];
    line.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<CGAL::Triple<int, int, int>> patch;
  // The slow search over all triangulations is cubic: only for short loops when the Delaunay search finds
  // none.
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(
      line, std::back_inserter(patch),
      CGAL::parameters::use_delaunay_triangulation(true).do_not_use_cubic_algorithm(loop.size() > 200));
  std::vector<Triangle> triangles;
  if (patch.size() != loop.size() - 2) return triangles;
  for (const auto& t : patch) triangles.push_back({loop[t.first], loop[t.second], loop[t.third]});
  return triangles;
}

}  // namespace vacuform
