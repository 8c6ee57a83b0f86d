// The part of the sheet that the clamp frame leaves uncovered.
#pragma once

#include <Eigen/Core>

#include "api/settings.hpp"

namespace vacuform {

// The nearest place inside the frame's opening, `inset_mm` from its edge at least; the place itself where it is there.
Eigen::Vector2d nearest_in_window(const Eigen::Vector2d& sheet, const MachineSettings& machine,
                                  double inset_mm);

inline bool in_window(const Eigen::Vector2d& sheet, const MachineSettings& machine) {
  return nearest_in_window(sheet, machine, 0) == sheet;
}

}  // namespace vacuform
