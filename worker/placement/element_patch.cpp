#include "worker/placement/element_patch.hpp"

#include <algorithm>
#include <cmath>

#include "worker/placement/bumpy_patch.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

}  // namespace

Result<ElementPatch> element_patch(const ChartedSurface& charted, const SheetPoint& centre,
                                   const Vector3d& axis, double ink_mm, CoilKeep keep, const Context& context,
                                   bool rough) {
  constexpr double margin_mm = 3, widest_step_mm = 1.8;
  // A geodesic radius is larger than the flat one on a dome: by 2 % at 80 mm on a small head.
  const double reach = 1.08 * ink_mm + margin_mm;
  const int directions =
      std::clamp(4 * static_cast<int>(std::ceil(M_PI / 2 * reach / widest_step_mm)), 96, 240);
  const PolarGrid grid(charted, centre, axis, reach, keep, directions);
  const bool folded = grid.folded(ink_mm);
  if (rough || !folded) {
    ElementPatch patch = grid.patch();
    patch.smooth = !folded;
    return patch;
  }
  return bumpy_patch(charted, centre, axis, ink_mm, keep, context);
}

ElementMap::ElementMap(const ElementPatch& patch)
    : patch_(&patch), locator_(patch.patch.triangles, patch.patch.uv) {}

std::optional<Vector3d> ElementMap::place(const Vector2d& flat) const {
  const auto found = locator_.find(flat);
  if (!found) return {};
  return interpolate(patch_->patch.triangles, *found, patch_->patch.inked);
}

bool ElementMap::on_chart(const Vector2d& flat) const {
  const auto found = locator_.find(flat);
  return found && patch_->on_chart[found->triangle] != 0;
}

}  // namespace vacuform
