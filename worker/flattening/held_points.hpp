// What holds a chart in the plane while it is flattened: its pins, or without any a corner of its first triangle.
#pragma once

#include "worker/flattening/chart_matrix.hpp"

namespace vacuform {

// A pin is a spring between a point of a triangle and its target. It couples only corners that the triangle couples
// anyway, and so costs the factorization nothing. At this stiffness against a triangle's own, about 1 times its weight,
// pins that disagree with the surface by several millimetres are met within a thousandth of one.
constexpr double pin_stiffness = 1e5;

// The chart's pins; without any the first corner, held where it stands: it only says where the chart comes to lie.
std::vector<ChartPin> held_points(const Chart& chart);
// Their springs' stiffness in this chart: pin_stiffness times its largest weight.
double stiffness_of_pins(const Chart& chart);

// A point of the chart.
Eigen::Vector2d place_of(const Chart& chart, const ChartPin& pin);

// Adds the springs' matrix, stiffness b b' in each coordinate with b the barycentric weights.
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

// Turns and shifts the chart so that the pins come nearest to their targets (least squares); one pin only shifts.
void move_onto_pins(std::vector<Eigen::Vector2d>& uv, const std::vector<Triangle>& triangles,
                    const std::vector<ChartPin>& pins);

}  // namespace vacuform
