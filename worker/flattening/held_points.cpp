#include "worker/flattening/held_points.hpp"

#include "worker/numerics/rigid_fit.hpp"

namespace vacuform {

namespace {
Eigen::Vector2d place_in(const std::vector<Eigen::Vector2d>& uv, const std::vector<Triangle>& triangles,
                         const ChartPin& pin) {
  const Triangle& t = triangles[pin.triangle];
  return pin.corners[0] * uv[t[0]] + pin.corners[1] * uv[t[1]] + pin.corners[2] * uv[t[2]];
}
}  // namespace

std::vector<ChartPin> held_points(const Chart& chart) {
  if (!chart.pins.empty()) return chart.pins;
  return {{0, Eigen::Vector3d::UnitX(), chart.uv[chart.triangles[0][0]]}};
}

double stiffness_of_pins(const Chart& chart) {
  double largest = 1;
  for (const double w : chart.weight) largest = std::max(largest, w);
  return pin_stiffness * largest;
}

Eigen::Vector2d place_of(const Chart& chart, const ChartPin& pin) {
  return place_in(chart.uv, chart.triangles, pin);
}

void move_onto_pins(std::vector<Eigen::Vector2d>& uv, const std::vector<Triangle>& triangles,
                    const std::vector<ChartPin>& pins) {
  RigidFit fit;
  for (const ChartPin& pin : pins) fit.add(place_in(uv, triangles, pin), pin.target);
  const Eigen::Vector2d from = fit.from(), to = fit.to();
  const Eigen::Rotation2Dd turn(pins.size() > 1 ? fit.angle() : 0.0);
  for (auto& p : uv) p = to + turn * (p - from);
}

}  // namespace vacuform
