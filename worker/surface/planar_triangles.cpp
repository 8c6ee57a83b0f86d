// The only use of CGAL's constrained Delaunay triangulation.
#include "worker/surface/planar_triangles.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

namespace vacuform {
namespace {

struct Number {
  int value = -1;
};
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Number, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<Number, Kernel,
                                              CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_predicates_tag>;

// From outside inwards: the level rises by one at each outline.
void set_levels(Triangulation& triangulation) {
  std::vector<Triangulation::Face_handle> level{triangulation.infinite_face()}, next;
  for (int depth = 0; !level.empty(); ++depth, level.swap(next)) {
    next.clear();
    while (!level.empty()) {
      const auto face = level.back();
      level.pop_back();
      if (face->info().value >= 0) continue;
      face->info().value = depth;
      for (int k = 0; k < 3; ++k) {
        const auto neighbour = face->neighbor(k);
        if (neighbour->info().value < 0)
          (triangulation.is_constrained({face, k}) ? next : level).push_back(neighbour);
      }
    }
  }
}

}  // namespace

PlanarTriangles triangulate(const std::vector<std::vector<Eigen::Vector2d>>& rings) {
  PlanarTriangles out;
  Triangulation triangulation;
  std::vector<std::vector<Triangulation::Vertex_handle>> outlines;
  for (const auto& ring : rings) {
    auto& handles = outlines.emplace_back();
    for (const Eigen::Vector2d& p : ring) {
      const auto vertex = triangulation.insert({p.x(), p.y()});
      if (vertex->info().value < 0)
        vertex->info().value = static_cast<int>(out.points.size());
      else
        out.simple = false;
      out.points.push_back(p);
      handles.push_back(vertex);
    }
  }
  for (const auto& handles : outlines)
    for (std::size_t i = 0; i < handles.size(); ++i)
      if (const auto next = handles[(i + 1) % handles.size()]; next != handles[i])
        triangulation.insert_constraint(handles[i], next);
  if (triangulation.dimension() < 2) return out;
  for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v) {
    if (v->info().value >= 0) continue;
    out.simple = false;
    v->info().value = static_cast<int>(out.points.size());
    out.points.emplace_back(v->point().x(), v->point().y());
  }
  for (auto face = triangulation.all_faces_begin(); face != triangulation.all_faces_end(); ++face)
    face->info().value = -1;
  set_levels(triangulation);
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end(); ++face)
    if (face->info().value % 2 == 1)
      out.triangles.push_back(
          {face->vertex(0)->info().value, face->vertex(1)->info().value, face->vertex(2)->info().value});
  return out;
}

}  // namespace vacuform
