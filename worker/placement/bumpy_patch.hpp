// The patch of an element where geodesics cross. Internal to worker/placement.
#pragma once

#include "worker/placement/element_patch.hpp"

namespace vacuform {

// As element_patch() says for bumps. Errors: cancelled.
Result<ElementPatch> bumpy_patch(const ChartedSurface& charted, const SheetPoint& centre,
                                 const Eigen::Vector3d& axis, double ink_mm, CoilKeep keep,
                                 const Context& context);

}  // namespace vacuform
