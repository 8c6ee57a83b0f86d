// The flat sheet: a regular triangulation that follows the clamp frame's window exactly.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "api/settings.hpp"
#include "worker/numerics/paired_cholesky.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

struct SheetGrid {
  std::vector<Eigen::Vector2d> rest;   // sheet coordinates (s, t), row by row from the lower left
  std::vector<Triangle> triangles;     // counter-clockwise seen from above
  std::vector<double> columns, rows;   // s of the grid's columns, t of its rows
  std::vector<char> clamped;           // per vertex: on or outside the window
  std::vector<int> elimination_order;  // nested dissection of the grid: all vertices, separators last
  Dissection dissection;               // the parts of that order
};

// Spacing is at most resolution_mm in both directions. Grid lines run along the edges of a rectangular window; a
// circular window has the vertices nearest to it moved onto it. Diagonals alternate
// (union jack), so that the grid prefers no direction.
SheetGrid make_sheet_grid(const SheetSettings& sheet, const MachineSettings& machine);

}  // namespace vacuform
