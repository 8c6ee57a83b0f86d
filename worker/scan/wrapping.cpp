// The only use of CGAL's alpha wrap.
#include "worker/scan/wrapping.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <type_traits>

namespace vacuform {
namespace {

using Exact = CGAL::Exact_predicates_inexact_constructions_kernel;

struct Stopped {
  bool cancelled;
};

// The remaining cost of the wrap on this thread, in tests. The search tree of CGAL makes its own kernels, so a kernel
// cannot carry the count.
thread_local std::int64_t tests_left = 0;

template <class Test>
struct Counted : Test {
  Counted(const Test& test) : Test(test) {}
  template <class... Arguments>
  decltype(auto) operator()(const Arguments&... arguments) const {
    constexpr bool of_a_box = (std::is_same_v<Arguments, CGAL::Bbox_3> || ...);
    tests_left -= of_a_box ? 1 : 4;
    if (tests_left < 0) throw Stopped{false};
    return Test::operator()(arguments...);
  }
};

// Counts the queries of the search tree about triangles.
struct Kernel : Exact {
  using Do_intersect_3 = Counted<Exact::Do_intersect_3>;
  using Construct_projected_point_3 = Counted<Exact::Construct_projected_point_3>;
  Do_intersect_3 do_intersect_3_object() const { return Exact::do_intersect_3_object(); }
  Construct_projected_point_3 construct_projected_point_3_object() const {
    return Exact::construct_projected_point_3_object();
  }
};
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

// CGAL calls this between its steps; an exception is the only way out that works in both 5.5 and 6.
struct Watch {
  const ScanProgress* progress;
  int most_steps;
  int steps = 0;
  std::int64_t shown_at = tests_left;  // when the listener was last notified

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
    if (++steps % 1024 != 0 && shown_at - tests_left < 1'000'000) return;
    shown_at = tests_left;
    if (!progress->tick()) throw Stopped{true};
    if (steps > most_steps) throw Stopped{false};
  }
  // NOLINTBEGIN(readability-identifier-naming): CGAL's names
  template <class W, class P>
  void before_Steiner_point_insertion(const W&, const P&) {}
  template <class W, class V>
  void after_Steiner_point_insertion(const W&, V) {}
  // NOLINTEND(readability-identifier-naming)
};

// The search tree halves triangles, over their longest edge, until none is longer than 3 alpha. Subtracts what the
// pieces cost in time and memory: each as much as forty tests. Lengths are squared.
void charge_pieces(double a, double b, double c, double longest) {
  if (a < b) std::swap(a, b);
  if (a < c) std::swap(a, c);
  if (!(a > longest)) return;
  tests_left -= 40;
  if (tests_left < 0) throw Stopped{false};
  const double median = std::max(0.0, (2 * b + 2 * c - a) / 4);
  charge_pieces(b, a / 4, median, longest);
  charge_pieces(c, a / 4, median, longest);
}

}  // namespace

Result<TriangleMesh> wrap(const TriangleMesh& soup, double alpha, double offset, const ScanProgress& progress,
                          WrapBudget& budget) {
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
    return fail(Code::unusable_scan, "all triangles of the scan are without area", "",
                "export the scan again");
  Surface surface;
  tests_left = budget.tests;
  Watch watch{&progress, budget.steps};
  try {
    for (const auto& f : faces)
      charge_pieces(CGAL::squared_distance(points[f[0]], points[f[1]]),
                    CGAL::squared_distance(points[f[1]], points[f[2]]),
                    CGAL::squared_distance(points[f[2]], points[f[0]]), 9 * alpha * alpha);
    // CGAL 5.5 expects the visitor among the parameters of the output, 6 among those of the input.
    CGAL::alpha_wrap_3(points, faces, alpha, offset, surface,
                       CGAL::parameters::visitor(watch).geom_traits(Kernel()),
                       CGAL::parameters::visitor(watch));
    budget.tests = tests_left;
  } catch (const Stopped& stopped) {
    budget.tests = std::max<std::int64_t>(0, tests_left);
    if (stopped.cancelled) return fail(Code::cancelled, "cancelled");
    return fail(Code::unusable_scan, "the surface of the scan is too complex to wrap", "",
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
