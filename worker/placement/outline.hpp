// What placement needs to know about an element: how far its ink reaches, and the loop of its coil.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

struct Outline {
  double reach_mm = 0;   // from the element's centre to its farthest ink
  double radius_mm = 0;  // of the circle with the area of the loop; without a loop the reach
  double width_mm = 1;   // of the loop's line
  // That of a coil about its centre, counter-clockwise and without repeating its first point; empty for other elements.
  std::vector<Eigen::Vector2d> loop;
  std::vector<Eigen::Vector2d> points;  // of all curves, about the centre

  bool is_loop() const { return !loop.empty(); }
};

// Pattern coordinates times `scale`, mm. Loops have about a hundred points.
Outline outline(const Element& element, double scale);

}  // namespace vacuform
