// Wrapping: a new watertight skin around any soup of triangles.
#pragma once

#include <cstdint>

#include "api/base/error.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// What wrapping may still cost, counted so that the same scan ends the same way on every machine. A step treats one
// facet. A test asks whether a triangle and a box meet, 0.1 microseconds on average; a query of a triangle with a ball,
// a tetrahedron or a point counts as four. A step makes some 150 tests on a scan and thousands where long thin
// triangles meet in a point. A wrap subtracts the tests that it used from `tests`; `steps` limits each wrap separately.
struct WrapBudget {
  std::int64_t tests;
  int steps = 400'000;
};

// A watertight, outwards oriented, two-manifold skin free of self-intersections at distance `offset` mm
// around the triangles; openings narrower than about `alpha` mm are bridged. Facets are about alpha wide, and
// their vertices lie at the offset: on a surface of radius R the facets' middles fall short by about alpha^2
// / (6 R). Alliez, Cohen-Steiner, Hemmer, Portaneri, Rouxel-Labbe 2022, "Alpha wrapping with an offset"
// (CGAL). Deterministic. Memory and time grow with area / alpha^2. Errors: cancelled; unusable_scan when the budget is
// used up.
Result<TriangleMesh> wrap(const TriangleMesh& soup, double alpha, double offset, const ScanProgress& progress,
                          WrapBudget& budget);

}  // namespace vacuform
