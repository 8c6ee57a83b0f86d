// Centres on the surface, who is whose neighbour, and the least squares that gives neighbours their distances.
#pragma once

#include <vector>

#include "worker/placement/charted_surface.hpp"
#include "worker/surface/geodesic.hpp"

namespace vacuform {

// A centre with the direction of the drawing's u axis there, carried along parallel as the centre moves.
struct Centre {
  SheetPoint point{};
  Eigen::Vector3d axis{1, 0, 0};  // unit, in the plane of the point's triangle
  Eigen::Vector2d drawn{0, 0};    // in the drawing at its scale, mm
  Eigen::Vector2d moved{0, 0};    // sum of all moves along axis and across it, mm
  double radius_mm = 0;           // of the loop
};

// Moves the centre by geodesics: mm along the axis and across it (counter-clockwise). Stops at the border of the sheet.
void move(const InkedSurface& surface, Centre& centre, const Eigen::Vector2d& by);

struct Neighbours {
  int a = 0, b = 0;  // a < b
  double drawn_mm = 0;
};

// Which elements are neighbours in the drawing: those nearest in units of the sum of their radii, and all up to 1.25 times
// as far, as either of the two sees it, if that is within 1.25 of the sum. So a hexagonal array (0.76 of the sum between
// neighbours) gives its nearest pairs and not the next (1.31), and coils drawn with a gap of a quarter of their
// size still are neighbours. In the order of a, then b.
std::vector<Neighbours> neighbours(const std::vector<Centre>& centres);

// Moves the centres so that the geodesic distances of neighbours are the drawn ones, in the least squares sense: Gauss and
// Newton's method, whose gradients are the directions in which the geodesics arrive. The array as a whole neither drifts
// nor turns: the moves, taken in the drawing, have no mean and no mean moment about the middle of the centres. What no
// pair holds stays where it is. Until no centre moves by a micrometre. Deterministic. Errors: cancelled.
Result<void> multilaterate(const ChartedSurface& charted, std::vector<Centre>& centres,
                           const std::vector<Neighbours>& pairs, const Context& context);

// The turn of each centre's axis, radians, that brings the drawn directions to its neighbours nearest to the directions
// on the surface (Procrustes); 0 without neighbours.
std::vector<double> turns(const ChartedSurface& charted, const std::vector<Centre>& centres,
                          const std::vector<Neighbours>& pairs);

}  // namespace vacuform
