// The inked surface around a point in polar coordinates: geodesics traced in all directions, with a grid point every
// millimetre or so (the exponential map). Distances from the centre are exact at every grid point.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/placement/charted_surface.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/geodesic.hpp"

namespace vacuform {

struct ElementPatch;

class PolarGrid {
 public:
  // Out to `reach_mm` along the surface. Direction 0 is `axis`, in the plane of the centre's triangle; the others
  // follow counter-clockwise as seen from outside. `directions` at least 8. A hundredth of a second for 40 mm.
  PolarGrid(const ChartedSurface& charted, const SheetPoint& centre, const Eigen::Vector3d& axis,
            double reach_mm, CoilKeep keep, int directions = 96);

  // *Flat polar coordinates* preserve the direction from the centre. The setting coils.keep says what else they
  // preserve. With area, the geodesic radius becomes that of the circle of the same area in the plane, so a drawing in
  // these coordinates has its drawn area around the centre. On a sphere of R = 85 mm a circle of 80 mm becomes 80.76 mm
  // across. Where geodesics end at the border of the sheet, the other directions replace the missing ones. With
  // diameter, the geodesic radius stays, so every straight line through the centre has its drawn length along the
  // surface, in all directions: a circle has its drawn geodesic diameter, other shapes their drawn lengths across
  // through the centre. On the same sphere a circle of 80 mm is 80.00 mm across and encloses 1.9 % less than in the
  // drawing.
  double flat_radius(double geodesic_mm) const;
  double geodesic_radius(double flat_mm) const;

  // The place of flat coordinates, linear in the cells of the grid; nothing beyond the reach or the border of the
  // sheet.
  std::optional<Eigen::Vector3d> place(const Eigen::Vector2d& flat) const;
  bool on_chart(const Eigen::Vector2d& flat) const;
  // Whether geodesics cross before `flat_mm`, so that places there have more than one direction.
  bool folded(double flat_mm) const;

  // The grid as triangles with `uv` = flat coordinates; a triangle is on the chart if all its corners are.
  ElementPatch patch() const;

  // The points that the geodesics pass, as direction (radians) and sheet coordinates.
  struct Passing {
    double direction;
    Eigen::Vector2d rest;
  };
  std::vector<Passing> passing() const;

 private:
  struct Stop {
    bool there = false, on_chart = false;
    Eigen::Vector2d rest{0, 0};
    Eigen::Vector3d inked{0, 0, 0};
  };
  // Ring 0 is the centre, repeated for each direction.
  const Stop& stop(int ring, int direction) const {
    return stops_[index(ring * directions_ + (direction % directions_))];
  }
  struct Cell {
    int ring, direction;
    double outward, onward;  // within the cell, in [0, 1]
  };
  std::optional<Cell> cell(const Eigen::Vector2d& flat) const;
  void measure();

  int directions_, rings_;
  double spacing_;
  std::vector<Stop> stops_;
  std::vector<double> flat_;  // flat radius of each ring
};

}  // namespace vacuform
