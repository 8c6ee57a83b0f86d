// The plane around a chart as triangles, so that a flattening that turns none of them over cannot overlap itself.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Constrained Delaunay triangles, counter-clockwise, of the convex hull of `points` minus the area of the chart.
// `loops` are the border of the chart, indices into points, and must not cross themselves or each other. Points inside
// the chart are only allowed on the loops; points outside, for example of a circle around it, are allowed.
// Deterministic.
std::vector<Triangle> triangles_outside(const std::vector<Eigen::Vector2d>& points,
                                        const std::vector<std::vector<int>>& loops,
                                        const std::vector<int>& around);

}  // namespace vacuform
