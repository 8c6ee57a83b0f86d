// An element's patch where geodesics cross. Internal to worker/coils.
#pragma once

#include "worker/placement/element_patch.hpp"

namespace vacuform {

// As element_patch() says for bumps. Errors: cancelled.
Result<ElementPatch> bumpy_patch(const InkedSurface& surface, const SheetPoint& centre,
                                 const Eigen::Vector3d& axis, double ink_mm, CoilKeep keep,
                                 const Context& context);

}  // namespace vacuform
