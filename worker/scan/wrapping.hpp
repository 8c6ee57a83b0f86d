// Wrapping: a new watertight skin around any soup of triangles.
#pragma once

#include "api/error.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/scan/triangle_mesh.hpp"

namespace vacuform {

// A watertight, outwards oriented, two-manifold skin free of self-intersections at distance `offset` mm
// around the triangles; openings narrower than about `alpha` mm are bridged. Facets are about alpha wide, and
// their vertices lie at the offset: on a surface of radius R the facets' middles fall short by about alpha^2
// / (6 R). Alliez, Cohen-Steiner, Hemmer, Portaneri, Rouxel-Labbe 2022, "Alpha wrapping with an offset"
// (CGAL). Deterministic. Memory and time grow with area / alpha^2; a step takes about 20 microseconds. Errors: cancelled;
// unusable_scan after `most_steps`.
Result<TriangleMesh> wrap(const TriangleMesh& soup, double alpha, double offset, const ScanProgress& progress,
                          int most_steps = 400'000);

}  // namespace vacuform
