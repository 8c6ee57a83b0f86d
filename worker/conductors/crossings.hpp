// Where the loops of an array cross on the sheet.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

struct Crossing {
  int a = 0, b = 0;                 // indices into Drawing::elements, a <= b
  double along_a = 0, along_b = 0;  // mm along their loops in the drawing (loop_path.hpp)
  double sine = 1;                  // of the angle between them on the part, above 0
  Eigen::Vector2d rest{0, 0};       // sheet coordinates, mm
  Eigen::Vector3d place{0, 0, 0};   // on the inked surface, mm
};

// By a, b and the lengths along a. Of loops as their patches lay them, or else the charts; what lies beyond these does not
// count. A loop that crosses itself is both. Near linear in the points of the loops and the crossings. Deterministic.
std::vector<Crossing> crossings(const Drawing& drawing, const Placement& placement);

}  // namespace vacuform
