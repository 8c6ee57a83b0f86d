// The one user of CGAL's alpha wrap.
#include "worker/scan/wrapping.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>

namespace vacuform {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

struct Stopped {
  bool cancelled;
};

// CGAL calls this between its steps; leaving by an exception is the one way out that both 5.5 and 6 know.
struct Watch {
  const ScanProgress* progress;
  int most_steps;
  int steps = 0;

  template <class W>
  void on_alpha_wrapping_begin(const W&) {}
  template <class W>
  void on_flood_fill_begin(const W&) {}
  template <class W>
  void on_flood_fill_end(const W&) {}
  template <class W>
  void on_alpha_wrapping_end(const W&) {}
  template <class W>
  constexpr bool go_further(const W&) {
    return true;
  }
  template <class W, class G>
  void before_facet_treatment(const W&, const G&) {
    if (++steps % 1024 != 0) return;
    if (!progress->tick()) throw Stopped{true};
    if (steps > most_steps) throw Stopped{false};
  }
  template <class W, class P>
  void before_Steiner_point_insertion(const W&, const P&) {}
  template <class W, class V>
  void after_Steiner_point_insertion(const W&, V) {}
};

}  // namespace

Result<TriangleMesh> wrap(const TriangleMesh& soup, double alpha, double offset, const ScanProgress& progress,
                          int most_steps) {
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> faces;
  points.reserve(soup.vertices.size());
  for (const auto& p : soup.vertices) points.emplace_back(p.x(), p.y(), p.z());
  for (const auto& t : soup.triangles) {
    std::array<std::size_t, 3> face;
    for (std::size_t k = 0; k < 3; ++k) face[k] = static_cast<std::size_t>(t[k]);
    if (!CGAL::collinear(points[face[0]], points[face[1]], points[face[2]])) faces.push_back(face);
  }
  if (faces.empty())
    return fail(Code::unusable_scan, "all triangles of the scan are without area", "", "export the scan again");
  Surface surface;
  Watch watch{&progress, most_steps};
  try {
    // CGAL 5.5 looks for the visitor among the parameters of the output, 6 among those of the input.
    CGAL::alpha_wrap_3(points, faces, alpha, offset, surface, CGAL::parameters::visitor(watch),
                       CGAL::parameters::visitor(watch));
  } catch (const Stopped& stopped) {
    if (stopped.cancelled) return fail(Code::cancelled, "cancelled");
    return fail(Code::unusable_scan, "the scan's surface is too intricate to be wrapped anew", "",
                "repair it in a mesh editor (close its holes, remove inner parts) and export it again");
  }
  TriangleMesh mesh;
  mesh.vertices.reserve(surface.number_of_vertices());
  std::vector<int> number(surface.number_of_vertices() + surface.number_of_removed_vertices(), -1);
  for (const auto v : surface.vertices()) {
    number[v.idx()] = static_cast<int>(mesh.vertices.size());
    const auto& p = surface.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : surface.faces()) {
    Triangle t{};
    std::size_t k = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f))) t[k++] = number[v.idx()];
    mesh.triangles.push_back(t);
  }
  return mesh;
}

}  // namespace vacuform
