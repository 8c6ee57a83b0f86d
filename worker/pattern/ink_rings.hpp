// Circular loops that touch or overlap in a picture, separated by the circles along which their ink ends.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

struct InkRing {
  Eigen::Vector2d centre;  // pattern coordinates, mm
  double radius, half_width;

  // Whether a point lies on the ring, or next to it by no more than `beyond` mm.
  bool holds(const Eigen::Vector2d& uv, double beyond) const {
    return std::abs((uv - centre).norm() - radius) <= half_width + beyond;
  }
};

// The rings of 4 to 100 mm radius in one connected piece of ink. `outlines`: closed polylines as Curves, ink on their
// left; `inked` tells whether a point is. A ring shows its outer and its inner circle over at least a quarter of their
// length each, fitted to a tenth of a millimetre or so, and has ink nearly all around. Largest support first. Centres
// are found by votes along the outlines' normals (after Duda and Hart 1972, "Use of the Hough transformation to detect
// lines and curves in pictures", with directions as in Kimme, Ballard, Sklansky 1975). Deterministic.
std::vector<InkRing> find_rings(const std::vector<Curve>& outlines,
                                const std::function<bool(const Eigen::Vector2d&)>& inked);

}  // namespace vacuform
