// From the vertices of one grid of a sheet to those of another of the same sheet and window.
#pragma once

#include <array>
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

// The same without kinks between the cells: bicubic, by Hermite's formula on the slopes of the parabola through three
// lines (Catmull-Rom where they are equidistant). Along the edges of the window, where the sheet has a kink, the slopes are
// those of each side.
class SmoothInterpolation {
 public:
  // `rest`: where the vertices of `from` are; some may be off its grid lines.
  SmoothInterpolation(const SheetGrid& from, const std::vector<Eigen::Vector2d>& rest,
                      const std::vector<Eigen::Vector2d>& to);
  // The values at all points of `to`; values: one column a vertex of `from`.
  Points operator()(const Points& values) const;
  // The corners of the cell of `from` around a point of `to`, and their bilinear weights.
  std::array<int, 4> corners(std::size_t point) const;
  std::array<double, 4> shares(std::size_t point) const;

 private:
  struct Line {
    int at;       // the line before
    double part;  // of the way to the next
    int first;    // line of the first weight
    std::array<double, 4> weight;
  };
  static Line line(const std::vector<double>& lines, const std::vector<char>& kink, double at);
  // The values on the grid lines.
  Points on_lines(const Points& values) const;

  const SheetGrid& grid_;
  std::vector<int> moved_;  // vertices off their grid lines
  std::vector<Eigen::Vector2d> off_;
  int columns_, rows_;
  std::vector<std::array<Line, 2>> places_;  // along s and t
};

}  // namespace vacuform
