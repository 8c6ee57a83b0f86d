// The coils of a drawing on a grid: which of them have their trace at a place, and in which it lies.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// Cells of at least .25 mm, at most about four million.
class CoilGrid {
 public:
  static constexpr int none = -1;

  explicit CoilGrid(const Eigen::AlignedBox2d& box);

  void add(int coil, const DrawnLoop& loop, const Eigen::Vector2d& centre);

  // At most two coils whose traces are there, or within .25 mm.
  std::array<int, 2> touched(const Eigen::Vector2d& at) const;
  // The coil in which the place lies; of several, the one whose centre is nearest, against its size.
  int inside(const Eigen::Vector2d& at) const;

 private:
  struct Cell {
    std::array<int, 2> trace{none, none};
    int inside = none;
    float off = 0;  // of the place from the centre, in radii
  };

  const Cell* find(const Eigen::Vector2d& at) const;
  std::size_t index_of(int x, int y) const;
  Eigen::Vector2d middle(int x, int y) const { return low_ + step_ * Eigen::Vector2d(x + 0.5, y + 0.5); }
  void add_trace(int coil, const DrawnLoop& loop);
  void add_inside(int coil, const DrawnLoop& loop, const Eigen::Vector2d& centre);

  Eigen::Vector2d low_;
  double step_;
  int columns_, rows_;
  std::vector<Cell> cells_;
};

}  // namespace vacuform
