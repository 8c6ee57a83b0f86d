// The parts of a coloured scan that the sheet cannot show: undercuts, and what lies under a bridge or inside.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/colour/coloured_surface.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// Of the surface above the platform.
struct HiddenSurface {
  double whole_mm2 = 0;
  double hidden_mm2 = 0;  // further from the formed sheet than full colour reaches
  struct Area {
    Eigen::Vector3d place;  // of its surface, near its middle; mold's frame, mm
    double mm2 = 0;
  };
  std::vector<Area> largest;  // connected ones of 25 mm2 and more, the largest first; at most five

  double share() const { return whole_mm2 > 0 ? hidden_mm2 / whole_mm2 : 0; }
};

// Examines places of the surface that are at most 2 mm apart, unless a side of a triangle is longer than 128 mm.
// Deterministic for any number of threads.
HiddenSurface hidden_surface(const ColouredSurface& surface, const FormedSheet& sheet, double touch_mm);

}  // namespace vacuform
