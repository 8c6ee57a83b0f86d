#include "worker/coils/exact_geodesics.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace vacuform {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Traits = CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>;
using Paths = CGAL::Surface_mesh_shortest_path<Traits>;
using Face = Mesh::Face_index;

// CGAL 5.5 goes wrong by millimetres from a source that is almost, but not quite, on an edge or a vertex (by 1e-15 or 1e-8
// of the triangle). So sources keep this share of it away from both: some 1e-5 mm.
constexpr double inside = 1e-5;

Eigen::Vector3d vector_of(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

struct Geodesics::State {
  Mesh mesh;
  std::unordered_map<int, Face> faces;  // looked up only
  std::unordered_map<Face, std::array<Mesh::Vertex_index, 3>> corners;
  std::unique_ptr<Paths> paths;
  Eigen::Vector3d source{0, 0, 0};

  // Nothing where the triangle is none of ours. No weight comes out less than `least`.
  // CGAL weighs a face's corners in the order of its halfedge, which need not begin with the first that was given.
  std::optional<std::pair<Face, Traits::Barycentric_coordinates>> place(const SheetPoint& at,
                                                                        double least) const {
    const auto found = faces.find(at.triangle);
    if (found == faces.end()) return std::nullopt;
    Eigen::Vector3d w = at.weights.cwiseMax(least);
    w /= w.sum();
    const Mesh::Halfedge_index h = mesh.halfedge(found->second);
    Traits::Construct_barycentric_coordinates barycentric;
    const auto weight = [&](Mesh::Vertex_index v) {
      for (std::size_t k = 0; k < 3; ++k)
        if (corners.at(found->second)[k] == v) return w[static_cast<Eigen::Index>(k)];
      return 0.0;
    };
    return std::pair{found->second, barycentric(weight(mesh.source(h)), weight(mesh.target(h)),
                                                weight(mesh.target(mesh.next(h))))};
  }
};

Geodesics::Geodesics(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& surface,
                     const std::vector<int>& which)
    : state_(std::make_unique<State>()) {
  std::unordered_map<int, Mesh::Vertex_index> vertices;
  for (const int t : which) {
    std::array<Mesh::Vertex_index, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const int v = triangles[static_cast<std::size_t>(t)][k];
      const auto [found, is_new] = vertices.try_emplace(v);
      if (is_new) {
        const Eigen::Vector3d& p = surface[static_cast<std::size_t>(v)];
        found->second = state_->mesh.add_vertex({p.x(), p.y(), p.z()});
      }
      corners[k] = found->second;
    }
    const Face face = state_->mesh.add_face(corners[0], corners[1], corners[2]);
    if (face == Mesh::null_face()) continue;  // at the ragged rim of what was cut out
    state_->faces.emplace(t, face);
    state_->corners.emplace(face, corners);
  }
  state_->paths = std::make_unique<Paths>(state_->mesh);
}

Geodesics::~Geodesics() = default;

bool Geodesics::begin_at(const SheetPoint& source) {
  const auto place = state_->place(source, inside);
  if (!place) return false;
  state_->paths->remove_all_source_points();
  state_->paths->add_source_point(place->first, place->second);
  state_->paths->build_sequence_tree();
  state_->source = vector_of(state_->paths->point(place->first, place->second));
  return true;
}

std::optional<Geodesics::Path> Geodesics::to(const SheetPoint& target) const {
  const auto place = state_->place(target, 0);
  if (!place) return std::nullopt;
  std::vector<Kernel::Point_3> points;
  const auto [length, source] = state_->paths->shortest_path_points_to_source_points(
      place->first, place->second, std::back_inserter(points));
  if (source == state_->paths->source_points_end() || !(length >= 0)) return std::nullopt;
  Eigen::Vector3d start(0, 0, 0);
  for (std::size_t i = points.size(); i-- > 0 && start.isZero(0);)
    if (const Eigen::Vector3d way = vector_of(points[i]) - state_->source; way.norm() > 1e-9)
      start = way.normalized();
  return Path{length, start};
}

std::vector<int> within_reach(const std::vector<Triangle>& triangles,
                              const std::vector<Eigen::Vector3d>& surface, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b, double length) {
  std::vector<int> near;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto corner = [&](std::size_t k) -> const Eigen::Vector3d& {
      return surface[static_cast<std::size_t>(triangles[t][k])];
    };
    double least = HUGE_VAL, edge = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      least = std::min(least, (corner(k) - a).norm() + (corner(k) - b).norm());
      edge = std::max(edge, (corner(k) - corner((k + 1) % 3)).norm());
    }
    if (least <= length + 2 * edge) near.push_back(static_cast<int>(t));
  }
  return near;
}

}  // namespace vacuform
