#include "worker/forming/heat/view_factor.hpp"

#include <cmath>
#include <numbers>

namespace vacuform {

namespace {

// Of the rectangle between the foot of the normal and the corner (x, y); odd in both.
double to_corner(double x, double y) {
  const double p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
  return (x / p * std::atan(y / p) + y / q * std::atan(x / q)) / (2 * std::numbers::pi);
}

}  // namespace

double view_factor(double x0, double x1, double y0, double y1, double height) {
  x0 /= height, x1 /= height, y0 /= height, y1 /= height;
  return to_corner(x1, y1) - to_corner(x0, y1) - to_corner(x1, y0) + to_corner(x0, y0);
}

}  // namespace vacuform
