// What the methods of flattening work on: a chart of triangles with the shape each has on the inked surface.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/context.hpp"
#include "worker/scan/triangle_mesh.hpp"

namespace vacuform {

struct Chart {
  std::vector<Triangle> triangles;     // indices into the arrays below, which hold the chart's vertices alone
  std::vector<Eigen::Vector3d> inked;  // the inked surface, mm
  std::vector<Eigen::Vector2d> uv;     // on entry the start (the flat sheet), on return the flattening, mm
};

struct FlatteningOutcome {
  int iterations = 0;
  bool converged = false;
};

// As-rigid-as-possible parameterization by local/global iterations (Liu, Zhang, Xu, Gotsman, Gortler, "A local/global
// approach to mesh parameterization", SGP 2008): one factorization, both coordinates at once, started from chart.uv.
// Stops when an iteration lowers the energy by less than a millionth. Deterministic. Errors: cancelled.
Result<FlatteningOutcome> flatten_arap(Chart& chart, const Context& context);

// CGAL's ARAP (Surface_mesh_parameterization), as the published predecessor used it: it starts from a map of its own
// and knows nothing of chart.uv. Needs a chart that is a topological disk. Errors: unusable_surface, cancelled
// (looked at before and after: CGAL cannot be interrupted).
Result<FlatteningOutcome> flatten_cgal_arap(Chart& chart, const Context& context);

// Singular values of the maps from the inked surface to the plane: the ARAP energy, sum A ((s1 - 1)^2 + (s2 - 1)^2)
// over the sum of A, and the number of triangles turned over.
struct ChartQuality {
  double energy = 0;
  int flipped = 0;
};
ChartQuality chart_quality(const Chart& chart);

// A triangle laid into its own plane without distortion: corners at (0, 0), (length, 0), (along, height), height >= 0.
struct FlatTriangle {
  double length, along, height;
};
FlatTriangle flat_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace vacuform
