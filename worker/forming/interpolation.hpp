// From the vertices of one grid of a sheet to those of another of the same sheet and window.
#pragma once

#include <vector>

#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform {

// Bilinear in sheet coordinates; a vertex that was moved onto a round window counts as if it were still on its grid lines.
class Interpolation {
 public:
  Interpolation(const SheetGrid& from, const SheetGrid& to);
  // The value at a vertex of `to`; values: one column a vertex of `from`.
  Eigen::Vector3d at(const Points& values, std::size_t vertex) const;

 private:
  struct Cell {
    int corner;  // its lower left vertex
    double u, v;
  };
  int columns_;
  std::vector<Cell> cells_;
};

}  // namespace vacuform
