// The noise of a scan's surface, and a copy without it. For decisions alone: a mold keeps the surface that was scanned.
#pragma once

#include <optional>

#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The standard deviation of the vertices from the smooth surface through their neighbours, along its normal, mm: the
// median of the second umbrella difference, which curvature hardly touches, over its gain for white noise. Facets count
// as noise of up to 3 % of their length. Borders are left out. O(n log n).
double noise_of(const TriangleMesh& mesh);

// Whether the edges of a body with that radius are longer than a twelfth of it on average: a model of flat faces, not a scan.
bool has_long_edges(const TriangleMesh& mesh, double radius);

// Whether the noise of a body with that radius is more than 0.2 % of it (0.2 mm on an adult head) and 5 % of an edge, and no
// edge is longer than a twelfth of the radius, as those of models are.
bool is_rough(const TriangleMesh& mesh, double radius);

// The mesh without noise: solves (I + L^2 / k^2) x = x0, where L is the umbrella operator (Desbrun, Meyer, Schroeder,
// Barr 1999, "Implicit fairing"). k is chosen so that noise of `noise_mm` is left with about `target_mm`, but waves
// longer than `longest_mm` are kept. Borders stay where they are. Same triangles; 50 to 300 rounds of conjugate
// gradients, O(n) each. Error: cancelled.
Result<TriangleMesh> smoothed(const TriangleMesh& mesh, double noise_mm, double target_mm, double longest_mm,
                              const ScanProgress& progress);

// A copy whose noise is smoothed to about 0.15 % of `radius`, that of the body, with waves longer than the radius kept.
// Nothing if it is not rough. Error: cancelled.
Result<std::optional<TriangleMesh>> without_noise(const TriangleMesh& mesh, double radius,
                                                  const ScanProgress& progress);

}  // namespace vacuform
