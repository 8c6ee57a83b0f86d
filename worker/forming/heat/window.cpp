#include "worker/forming/heat/window.hpp"

#include <algorithm>

namespace vacuform {

Eigen::Vector2d nearest_in_window(const Eigen::Vector2d& sheet, const MachineSettings& machine,
                                  double inset_mm) {
  const double w = machine.window_width_mm / 2 - inset_mm, h = machine.window_height_mm / 2 - inset_mm;
  if (machine.window == WindowShape::circle) {
    const double r = sheet.norm();
    return r > w ? Eigen::Vector2d(sheet * (w / r)) : sheet;
  }
  return {std::clamp(sheet.x(), -w, w), std::clamp(sheet.y(), -h, h)};
}

}  // namespace vacuform
