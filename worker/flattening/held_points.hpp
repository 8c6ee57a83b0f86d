// Constraints that hold a chart in the plane while it is flattened: its pins, or a corner of its first triangle.
#pragma once

#include "worker/flattening/chart_matrix.hpp"

namespace vacuform {

// A pin is a spring between a point of a triangle and its target. It couples only corners that the triangle couples
// anyway, so it adds no cost to the factorization. With this stiffness relative to that of a triangle, which is about 1
// times its weight, pins that disagree with the surface by several millimetres are met within a thousandth of a
// millimetre.
constexpr double pin_stiffness = 1e5;

// The pins of the chart. Without pins, the first corner at its current place: this only fixes where the chart lies.
std::vector<ChartPin> held_points(const Chart& chart);
// The stiffness of their springs in this chart: pin_stiffness times its largest weight.
double stiffness_of_pins(const Chart& chart);

// A point of the chart.
Eigen::Vector2d place_of(const Chart& chart, const ChartPin& pin);

// Adds the matrix of the springs, stiffness b b' in each coordinate with b the barycentric weights.
template <int D>
void add_pins(ChartMatrix<D>& matrix, const std::vector<ChartPin>& pins, double stiffness) {
  for (const ChartPin& pin : pins) {
    typename ChartMatrix<D>::Local local = ChartMatrix<D>::Local::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int d = 0; d < D; ++d) local(D * i + d, D * j + d) = stiffness * pin.corners[i] * pin.corners[j];
    matrix.add(static_cast<std::size_t>(pin.triangle), local);
  }
}

// Rotates and shifts the chart so that the pins come nearest to their targets (least squares); one pin only shifts.
void move_onto_pins(std::vector<Eigen::Vector2d>& uv, const std::vector<Triangle>& triangles,
                    const std::vector<ChartPin>& pins);

}  // namespace vacuform
