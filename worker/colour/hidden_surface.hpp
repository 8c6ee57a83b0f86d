// The parts of a coloured scan that no sheet shows: undercuts, and what lies under a bridge or inside.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/colour/coloured_surface.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// Of the surface above the platform.
struct HiddenSurface {
  double whole_mm2 = 0;
  double hidden_mm2 = 0;  // further from the formed sheet than the colours are full
  struct Area {
    Eigen::Vector3d place;  // of its surface, near its middle; mold's frame, mm
    double mm2 = 0;
  };
  std::vector<Area> largest;  // connected ones of 25 mm2 and more, the largest first; at most five

  double share() const { return whole_mm2 > 0 ? hidden_mm2 / whole_mm2 : 0; }
};

// Looks at places of the surface at most 2 mm apart. Deterministic for any number of threads.
HiddenSurface hidden_surface(const ColouredSurface& surface, const FormedSheet& sheet, double touch_mm);

}  // namespace vacuform
