// A piece of the inked surface on which the drawing is laid: the chart of the whole region, or one element's
// neighbourhood.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Triangles with, per vertex, the same point in three coordinates; linear within each triangle. Triangles are
// counter-clockwise in `rest` and, where nothing is folded, in `uv`. The vertices need not be the sheet's own.
struct Patch {
  std::vector<Triangle> triangles;
  std::vector<Eigen::Vector2d> uv;     // pattern coordinates, mm
  std::vector<Eigen::Vector2d> rest;   // sheet coordinates (s, t), mm
  std::vector<Eigen::Vector3d> inked;  // on the surface that carries the ink, mm
};

}  // namespace vacuform
