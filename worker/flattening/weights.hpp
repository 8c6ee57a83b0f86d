// Weights of the distortion of each triangle.
#pragma once

#include <functional>
#include <vector>

#include "worker/flattening/chart.hpp"

namespace vacuform {

// Coverage of the ink, in [0, 1], around a point of the chart (mm), averaged over a disk of `blur_mm`.
using InkCoverage = std::function<double(const Eigen::Vector2d& chart, double blur_mm)>;

// Geodesic distance on the inked surface of every vertex from the nearest source, mm; `start` holds the initial
// distances of the sources and infinity elsewhere. Front propagation (Dijkstra) with the straight line through two
// triangles if there is one (Novotni, Klein, "Computing geodesic distances on triangular meshes", WSCG 2002): accurate
// to about a per cent, O(n log n).
std::vector<double> surface_distance(const Chart& chart, std::vector<double> start);

// 1 at the border of the chart, `weight` at the point (barycentric `corners` of `triangle`) and, smoothly between,
//   1 + (weight - 1) x^2 (3 - 2 x),  x = rim / (rim + top),
// with the geodesic distances from the border and from the point, at the centre of each triangle.
std::vector<double> center_weights(const Chart& chart, int triangle, const Eigen::Vector3d& corners,
                                   double weight);

// 1 + (weight - 1) coverage, over a disk around the centre of the triangle, half as wide as its longest edge in the
// chart.
std::vector<double> painted_weights(const Chart& chart, const InkCoverage& paint, double weight);

// `weight` if a quarter or more of the area around the centre of the triangle (a disk half as wide as its longest edge
// in the chart) is inked, and 1 + (weight - 1) 4 coverage if less is.
std::vector<double> ink_weights(const Chart& chart, const InkCoverage& ink, double weight);

}  // namespace vacuform
