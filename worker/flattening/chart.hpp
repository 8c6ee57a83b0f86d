// The data that the flattening methods work on: a chart of triangles with the shape of each on the inked surface.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A point of a triangle, held at a point of the plane.
struct ChartPin {
  int triangle = 0;         // of Chart::triangles
  Eigen::Vector3d corners;  // barycentric weights
  Eigen::Vector2d target;   // mm
};

struct Chart {
  std::vector<Triangle> triangles;     // indices into the arrays below, only vertices of the chart
  std::vector<Eigen::Vector3d> inked;  // the inked surface, mm
  std::vector<Eigen::Vector2d> uv;     // on entry the start (the flat sheet), on return the flattening, mm
  std::vector<double> weight = {};     // per triangle, above 0: how much its distortion counts; empty: all 1
  std::vector<ChartPin> pins = {};     // none, or at least two: a single one only shifts the chart

  double weight_of(std::size_t triangle) const { return weight.empty() ? 1 : weight[triangle]; }
};

// A triangle laid into its own plane without distortion: corners at (0, 0), (length, 0), (along, height), height >= 0.
struct FlatTriangle {
  double length, along, height;
};
FlatTriangle flat_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// A linear triangle: with the places of the corners as columns of U, J = U gradient' maps its plane to the chart.
struct ChartElement {
  Eigen::Matrix<double, 3, 2> gradient;  // of the hat functions of the corners, one per row, 1/mm
  double area;                           // mm2
};
// One per triangle. A triangle flatter than a ten thousandth of its length counts as that high, so that every element
// has a map: slivers with any angle above 0.006 degrees are unchanged.
std::vector<ChartElement> elements(const Chart& chart);

inline Eigen::Matrix2d jacobian(const Chart& chart, const std::vector<ChartElement>& all, std::size_t k) {
  const Triangle& t = chart.triangles[k];
  Eigen::Matrix<double, 2, 3> U;
  U << chart.uv[t[0]], chart.uv[t[1]], chart.uv[t[2]];
  return U * all[k].gradient;
}

// How far the maps of the triangles are from rigid, regardless of the weights and pins of the flattening. s1 >= |s2|
// are the singular values of the map from the inked surface to the plane, s2 < 0 where a triangle is turned over:
struct ChartQuality {
  double arap = 0;  // sum A ((s1 - 1)^2 + (s2 - 1)^2) / sum A: 0 where nothing is distorted
  double symmetric_dirichlet =
      0;            // sum A (s1^2 + s2^2 + s1^-2 + s2^-2) / sum A: 4 there, infinite with a flip
  int flipped = 0;  // triangles turned over or without area in the plane
};
ChartQuality chart_quality(const Chart& chart);

}  // namespace vacuform
