// The surface around an element in its own flat coordinates, mm: origin at its centre, direction 0 along u of the
// drawing. They preserve either the area within every radius around the centre or the radius on the surface
// (polar_grid.hpp).
#pragma once

#include <optional>
#include <vector>

#include "worker/placement/patch.hpp"
#include "worker/placement/polar_grid.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

struct ElementPatch {
  Patch patch;                 // uv: flat coordinates
  std::vector<char> on_chart;  // per triangle
  bool smooth = true;          // geodesics from the centre do not cross within the ink's reach
};

// Extends to `ink_mm` (flat) and a margin. On a smooth surface it is the grid of geodesics, so that geodesic radii are
// the drawn ones, unless `keep` requires the area (PolarGrid). Where bumps make geodesics cross, it consists of the
// triangles of the sheet, with the direction of a local flattening (as rigid as possible) and the radius of the
// shortest geodesic. If that would still turn triangles over, the radius of the local flattening is mixed in as far as
// needed. With `rough` it is always the grid, which is many times faster where geodesics cross. Errors: cancelled.
Result<ElementPatch> element_patch(const ChartedSurface& charted, const SheetPoint& centre,
                                   const Eigen::Vector3d& axis, double ink_mm, CoilKeep keep,
                                   const Context& context, bool rough = false);

// Finds flat coordinates in a patch.
class ElementMap {
 public:
  explicit ElementMap(const ElementPatch& patch);  // which must outlive it
  // The place in space; nothing off the patch.
  std::optional<Eigen::Vector3d> place(const Eigen::Vector2d& flat) const;
  bool on_chart(const Eigen::Vector2d& flat) const;

 private:
  const ElementPatch* patch_;
  PlaneLocator locator_;
};

}  // namespace vacuform
