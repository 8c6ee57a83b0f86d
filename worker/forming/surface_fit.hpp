// How well the formed sheet lies on the mold, measured over the surfaces and not at vertices.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Penetration: how far the mold stands out of the sheet, over the part of the mold that is within 1 mm of the sheet or
// outside of it; 0 where the sheet covers it, or is less than 0.02 mm from covering it. Its max counts as well how deep the
// sheet lies in the mold. Gap: how far the sheet lies from the mold, over the triangles whose corners all touch the mold; 0
// where it lies inside. Percentiles are by area, on samples about 0.5 mm apart and at the mold's vertices. `pierced` and
// `bridged`: the parts beyond these limits; cells of 3 mm that touch make one part. `formed`, `contact`: per vertex of the
// sheet. Deterministic.
struct FitLimits {
  double pierced_mm = 0.5, bridged_mm = 0.5;
};
SurfaceFit surface_fit(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& formed,
                       const std::vector<Contact>& contact, const TriangleMesh& mold,
                       const FitLimits& limits = {});

}  // namespace vacuform
