#include "worker/forming/heat/temperature_field.hpp"

#include <algorithm>
#include <cmath>

namespace vacuform {

double TemperatureField::at(const Eigen::Vector2d& sheet) const {
  const int rows = static_cast<int>(celsius_.size()) / columns_;
  // The sample before a place along one direction, and how far the place is on to the next.
  const auto locate = [](double at, double length, int samples) {
    const double along = std::clamp(at / length + 0.5, 0.0, 1.0) * (samples - 1);
    const int before = std::min(static_cast<int>(along), std::max(0, samples - 2));
    return std::pair(before, along - before);
  };
  const auto [i, u] = locate(sheet.x(), width_, columns_);
  const auto [j, v] = locate(sheet.y(), height_, rows);
  const auto sample = [&](int column, int row) {
    return celsius_[std::min(row, rows - 1) * columns_ + std::min(column, columns_ - 1)];
  };
  return (1 - v) * ((1 - u) * sample(i, j) + u * sample(i + 1, j)) +
         v * ((1 - u) * sample(i, j + 1) + u * sample(i + 1, j + 1));
}

}  // namespace vacuform
