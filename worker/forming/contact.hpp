// What the sheet meets: the mold, the platform, and the wall that joins the clamp frame's window to the platform, found
// along the way from one place to the next.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/membrane.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/scan/ray_caster.hpp"

namespace vacuform {

class Obstacles {
 public:
  struct Touch {
    double t;               // along the way, in [0, 1]
    Eigen::Vector3d place;  // exactly on the mold's triangle, on the platform or on the wall
    Contact with;           // the wall counts as the clamp
  };

  Obstacles(const TriangleMesh& mold, const MachineSettings& machine);

  const TriangleMesh& mold() const { return mold_; }

  // The first place at which a point that moves straight from `from`, inside the window and not below the platform, to
  // `to` enters the mold or leaves the space between platform and wall.
  std::optional<Touch> first_touch(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  Eigen::Vector3d nearest_on_mold(const Eigen::Vector3d& place) const { return distance_.nearest(place); }

 private:
  // The smallest t in [0, 1] at which from + t way leaves the window, or nothing.
  std::optional<double> leaves_window(const Eigen::Vector3d& from, const Eigen::Vector3d& way) const;
  // Whether a segment certainly passes by the mold, by the mold's highest point in each cell. False does not say that
  // it meets the mold. Spares most rays.
  bool misses_mold(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  // First and last column, first and last row of the cells that a box meets; those at the edge beyond it.
  std::array<int, 4> cells(const Eigen::Vector3d& low, const Eigen::Vector3d& high) const;

  const TriangleMesh& mold_;
  RayCaster rays_;
  MoldDistance distance_;
  MachineSettings machine_;
  // Highest z of the triangles whose bounding boxes meet a square cell, row by row from low_.
  static constexpr double cell_mm = 2;
  Eigen::Array2d low_ = Eigen::Array2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<double> highest_;
};

// The sheet as an obstacle to itself: under an overhang of the mold two parts of it can be drawn against each other
// with their lower faces, where real sheet folds and stops.
class SheetAsObstacle {
 public:
  // x: one column a vertex; triangles counter-clockwise seen from above.
  SheetAsObstacle(const Points& x, const std::vector<Triangle>& triangles);

  // Whether the sheet overhangs in any triangle with a vertex that is not held: without that no two lower faces can
  // meet.
  static bool possible(const Points& x, const std::vector<Triangle>& triangles,
                       const std::vector<char>& held);

  // The fraction of the way from `from` to `to` after which a point of the sheet must stop so as not to pass through
  // another part of it from below, when that other part comes as far the other way; nothing when it is free to go.
  std::optional<double> stops(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

 private:
  TriangleMesh mesh_;
  RayCaster rays_;
};

}  // namespace vacuform
