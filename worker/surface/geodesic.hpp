// Straightest geodesics over the triangles of the inked surface (Polthier and Schmies, "Straightest geodesics on
// polyhedral surfaces", 1998): straight within a triangle, and unfolded straight over an edge. Where the surface does
// not fold the paths from a point together, they are also the shortest paths.
#pragma once

#include "worker/surface/inked_surface.hpp"

namespace vacuform {

// Traces a geodesic. A path that comes within a billionth of an edge of a vertex passes beside it, on its current side.
class GeodesicWalk {
 public:
  // `along`: a direction in the plane of the point's triangle, of any length but zero.
  GeodesicWalk(const InkedSurface& surface, const SheetPoint& start, const Eigen::Vector3d& along);

  // Moves on, and returns the millimetres moved: fewer than requested at the border of the sheet, where it stops.
  double advance(double mm);

  const SheetPoint& at() const { return at_; }
  const Eigen::Vector3d& along() const { return along_; }  // unit, in the plane of at()'s triangle
  bool ended() const { return ended_; }                    // at the border of the sheet

 private:
  void cross(int corner);  // over the edge opposite the corner
  const InkedSurface* surface_;
  SheetPoint at_;
  Eigen::Vector3d along_;
  int entered_ = -1;  // the corner opposite the edge that was crossed last, else -1
  bool ended_ = false;
};

// `direction` in the plane of triangle t, turned counter-clockwise as seen from outside.
Eigen::Vector3d turned(const InkedSurface& surface, int t, const Eigen::Vector3d& direction, double radians);
// Angle from one direction in the plane of triangle t to another, counter-clockwise, in (-pi, pi].
double angle_between(const InkedSurface& surface, int t, const Eigen::Vector3d& from,
                     const Eigen::Vector3d& to);

// The shortest geodesic from a to b, found by shooting from a in three directions around that to b. `found` is false if
// none came within a hundredth of the distance: then the other members hold the straight line in space.
struct Connection {
  double mm = 0;
  // Unit directions at a and, onward, at b; zero where the points coincide, or the direction is normal to the triangle.
  Eigen::Vector3d leaving{0, 0, 0}, arriving{0, 0, 0};
  bool found = false;
};
Connection connect(const InkedSurface& surface, const SheetPoint& a, const SheetPoint& b);

}  // namespace vacuform
