// The flat sheet as square cells that know how long a way over them is on the formed part: the ground on which tails are routed.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/surface/inked_surface.hpp"

namespace vacuform {

// How far each cell is from the edge of something, mm on the part; below 0 within it.
using Room = std::vector<float>;

class SheetCells {
 public:
  static constexpr double size_mm = 0.5;

  // The cells of a box of the sheet. O(cells).
  SheetCells(const InkedSurface& surface, const Eigen::AlignedBox2d& box);

  int count() const { return columns_ * rows_; }
  int at(const Eigen::Vector2d& rest) const;  // -1: beside the box
  Eigen::Vector2d middle(int cell) const;
  int triangle(int cell) const { return triangle_[static_cast<std::size_t>(cell)]; }  // -1: off the sheet
  // Up to eight; those beside the box are left out.
  std::vector<int> neighbours(int cell) const;

  // A short way from a cell, mm of the flat sheet, as it is on the part, mm. Infinite off the sheet.
  double on_part(int cell, const Eigen::Vector2d& way) const;

  static constexpr float open = 1e9F;
  Room open_ground() const { return Room(static_cast<std::size_t>(count()), open); }
  // Lowers the room to that beside a disc on the part, as far as `reach_mm` from its edge. Cells that were open ground are added
  // to `touched`.
  struct Disc {
    Eigen::Vector2d middle;  // sheet coordinates
    double radius_mm, reach_mm;
  };
  void keep_clear(const Disc& disc, Room& room, std::vector<int>& touched) const;

 private:
  Eigen::Vector2d low_;
  int columns_, rows_;
  std::vector<int> triangle_;
  std::vector<Eigen::Matrix2d> metric_;  // by triangles: F^T F of the map from the flat sheet to the part
};

}  // namespace vacuform
