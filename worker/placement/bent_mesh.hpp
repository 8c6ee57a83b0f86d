// Refines the triangles of a neighbourhood where a map of them bends. Internal to worker/placement.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "worker/surface/sheet_point.hpp"

namespace vacuform {

// Triangles that lie in triangles of the surface, with their own vertex numbers.
struct BentMesh {
  std::vector<Triangle> triangles;
  std::vector<int> faces;  // per triangle: the one of the surface that it lies in
  std::vector<std::array<Eigen::Vector3d, 3>> corners;  // per triangle: its corners' weights in that one
  std::vector<Eigen::Vector2d> rest;                    // per vertex: sheet coordinates, mm
  std::vector<Eigen::Vector3d> inked;                   // per vertex: on the inked surface, mm
  std::vector<Eigen::Vector2d> flat;                    // per vertex: linear in each triangle of the surface
  std::vector<double> radius;  // per vertex: not linear there, mm; infinite where unknown

  // Where the map puts a vertex: in the direction of `flat`, at this distance.
  Eigen::Vector2d mapped(int vertex) const;
};

// Halves edges whose midpoint the map puts more than `tolerance_mm` beside the midpoint of its ends. Repeats this up to
// three times, as far as `reach_mm` from the origin. `radius_at` gives a new vertex its radius. No hanging vertices.
void refine(BentMesh& mesh, const std::function<double(const SheetPoint&)>& radius_at, double reach_mm,
            double tolerance_mm);

}  // namespace vacuform
