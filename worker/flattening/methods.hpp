// The methods of flattening. Each takes a chart with its start in uv and leaves its flattening there, up to a rigid
// motion where the chart has no pins. All are deterministic, and end with Code::cancelled soon after a cancellation.
#pragma once

#include <optional>

#include "worker/flattening/chart.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct FlatteningOutcome {
  int iterations = 0;
  bool converged = false;
};

// As-rigid-as-possible parameterization by local/global iterations (Liu, Zhang, Xu, Gotsman, Gortler, "A local/global
// approach to mesh parameterization", SGP 2008): one factorization, both coordinates at once, started from chart.uv.
//   sum w A min over rotations R of |J - R|^2
// With `lambda` their hybrid, which lets a triangle grow at a price:
//   sum w A min over R and s of |J - s R|^2 + lambda (s^2 - 1)^2
// (their energy with lambda A instead of lambda, so that it depends neither on the grid nor on the unit). lambda above
// 0: towards 0 angles are kept at the cost of areas, and the number of iterations grows; without lambda it is the limit
// of a large one. Stops when the remaining gain is a millionth of the energy, or unconverged after `most_iterations`.
// Triangles can turn over.
Result<FlatteningOutcome> flatten_arap(Chart& chart, const Context& context,
                                       std::optional<double> lambda = {}, int most_iterations = 300);

// The symmetric Dirichlet energy, sum w A (s1^2 + s2^2 + s1^-2 + s2^-2) with the singular values of J, by projected
// Newton on its analytic eigensystem (Smith, de Goes, Kim, "Analytic eigensystems for isotropic distortion energies",
// ACM TOG 2019) with the longest step before a triangle turns over (Smith, Schaefer, "Bijective parameterization with
// free boundaries", SIGGRAPH 2015). No triangle is turned over, neither on return nor in between. The start is a few
// iterations of flatten_arap if they turn no triangle over, otherwise chart.uv, and if that covers anything twice,
// Tutte's embedding. If the border then overlaps itself, the solve is repeated with the plane around the chart as
// triangles that must not turn over either (Jiang, Schaefer, Panozzo, "Simplicial complex augmentation framework for
// bijective maps", SIGGRAPH Asia 2017), so that on return no point of the plane is covered twice. Errors:
// unusable_surface if the chart is not a disk and its start covers anything twice.
Result<FlatteningOutcome> flatten_symmetric_dirichlet(Chart& chart, const Context& context);

// Least squares conformal map with a free border, sum w A (s1 - s2)^2 (Levy, Petitjean, Ray, Maillot 2002; Mullen,
// Tong, Alliez, Desbrun, "Spectral conformal parameterization", SGP 2008, so that no two vertices need be chosen),
// scaled so that the area of the chart is that of the inked surface. With pins, which then set the scale, it is a
// single solve. Triangles can turn over.
Result<FlatteningOutcome> flatten_lscm(Chart& chart, const Context& context);

// Unfolding breadth first from triangle `seed`: each vertex is placed at the mean of the positions to which the first
// triangles that reach it, from two corners already placed, unfold it. Errors accumulate outwards; triangles turn over
// on any dome. Ignores weights and pins.
Result<FlatteningOutcome> flatten_breadth_first(Chart& chart, int seed, const Context& context);

// CGAL's ARAP (Surface_mesh_parameterization), as the published predecessor used it: it starts from its own map and
// ignores chart.uv, weights and pins. `lambda` is that of the library (if absent: its default of 1000), in mm2. Needs a
// chart that is a topological disk. Errors: unusable_surface, cancelled (checked before and after, because CGAL cannot
// be interrupted).
Result<FlatteningOutcome> flatten_cgal_arap(Chart& chart, const Context& context,
                                            std::optional<double> lambda = {});

}  // namespace vacuform
