#include "worker/coils/placement.hpp"

#include <cmath>

namespace vacuform {

namespace {

Eigen::Vector2d pattern_coordinates(const Eigen::Vector2d& chart, const PatternSettings& settings) {
  const double angle = settings.rotate_deg * M_PI / 180, c = std::cos(angle), s = std::sin(angle);
  const Eigen::Vector2d d = chart - Eigen::Vector2d(settings.offset_mm[0], settings.offset_mm[1]);
  return Eigen::Vector2d(c * d.x() + s * d.y(), -s * d.x() + c * d.y()) / settings.scale;
}

// The region of interest with the sheet's own triangles.
Patch chart_patch(const FormedSheet& sheet, const Flattening& flattening, const PatternSettings& settings) {
  Patch patch;
  std::vector<int> local(sheet.rest.size(), -1);
  for (const int t : flattening.triangles) {
    Triangle corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(sheet.triangles[static_cast<std::size_t>(t)][k]);
      if (local[v] < 0) {
        local[v] = static_cast<int>(patch.uv.size());
        patch.uv.push_back(pattern_coordinates(flattening.chart[v], settings));
        patch.rest.push_back(sheet.rest[v]);
        patch.inked.push_back(flattening.inked[v]);
      }
      corners[k] = local[v];
    }
    patch.triangles.push_back(corners);
  }
  return patch;
}

}  // namespace

Result<Placement> place(const FormedSheet& sheet, const Flattening& flattening, const Drawing*,
                        const Settings& settings, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  Placement out;
  out.chart = chart_patch(sheet, flattening, settings.pattern);
  return out;
}

}  // namespace vacuform
