// Centres on the surface, which elements are neighbours, and the least squares that sets the distances of neighbours.
#pragma once

#include <optional>
#include <vector>

#include "worker/placement/charted_surface.hpp"
#include "worker/surface/geodesic.hpp"

namespace vacuform {

// A centre with the direction of the u axis of the drawing there, transported in parallel as the centre moves.
struct Centre {
  SheetPoint point{};
  Eigen::Vector3d axis{1, 0, 0};  // unit, in the plane of the point's triangle
  Eigen::Vector2d drawn{0, 0};    // in the drawing at its scale, mm
  Eigen::Vector2d moved{0, 0};    // sum of all moves along axis and across it, mm
  double radius_mm = 0;           // of the loop
  bool fixed = false;             // stays in its place, with its axis, whatever its neighbours ask for
};

// Moves the centre along geodesics: mm along the axis and across it (counter-clockwise). Stops at the border of the
// sheet.
void move(const InkedSurface& surface, Centre& centre, const Eigen::Vector2d& by);

struct Neighbours {
  int a = 0, b = 0;  // a < b
  double drawn_mm = 0;
  double weight = 1;  // of the error of their distance, squared
};

// Which of `nodes` are neighbours in the drawing, in the order of a, then b: those with no other node in the circle over
// their distance (Gabriel, Sokal 1969, "A new statistical approach to geographic variation analysis"). So all nodes hang
// together, near and far, and a hexagonal or a square array gives its nearest pairs and not the next. Pairs farther
// apart than 1.25 times the sum of their radii count less, by the inverse square of their distance.
std::vector<Neighbours> neighbours(const std::vector<Centre>& centres, const std::vector<int>& nodes);

// Where an array lies as a whole: the place of the drawing's centre, and how far off the centres lie as seen from there,
// mm along its axis and across it. A centre is seen by the direction and the length of the geodesic to it, and its error
// is the difference to the drawing. The mean is weighted by the inverse fourth power of the distance in the drawing, so
// it is the error of a centre in the middle, or else of those around the middle.
struct Anchor {
  Centre origin;
  Eigen::Vector2d off{0, 0};
};
Eigen::Vector2d off_origin(const InkedSurface& surface, const Centre& origin,
                           const std::vector<Centre>& centres);

// Moves the centres so that the geodesic distances of neighbours are the drawn ones, in the least squares sense: the
// Gauss-Newton method, whose gradients are the directions in which the geodesics arrive. The array as a whole neither
// drifts nor rotates: the moves, in the drawing, have no mean and no mean moment about the centroid of the centres. With
// an anchor the array comes to lie by it instead of the mean, within some hundredths of a millimetre. A centre without
// pairs, or that is fixed, stays in place; with a fixed one nothing else holds the array as a whole. Ends when no centre moves by a micrometre. Deterministic. Errors: cancelled.
Result<void> multilaterate(const ChartedSurface& charted, std::vector<Centre>& centres,
                           const std::vector<Neighbours>& pairs, const Context& context,
                           const std::optional<Anchor>& anchor = {});

// The rotation of the axis of each centre, radians, that brings the drawn directions to its neighbours nearest to the
// directions on the surface (Procrustes); 0 without neighbours, or if it is fixed.
std::vector<double> turns(const ChartedSurface& charted, const std::vector<Centre>& centres,
                          const std::vector<Neighbours>& pairs);

}  // namespace vacuform
