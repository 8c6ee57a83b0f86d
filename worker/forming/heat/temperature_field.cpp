#include "worker/forming/heat/temperature_field.hpp"

#include <algorithm>
#include <cmath>

namespace vacuform {

double TemperatureField::at(const Eigen::Vector2d& sheet) const {
  const int rows = static_cast<int>(celsius_.size()) / columns_;
  // The sample before a place along one direction, and how far the place is on to the next.
  const auto locate = [&](double at, double length, int samples) {
    const double across = at / length + 0.5;
    const double along = std::clamp(
        samples_ == Samples::in_cells ? across * samples - 0.5 : across * (samples - 1), 0.0, samples - 1.0);
    const int before = std::min(static_cast<int>(along), std::max(0, samples - 2));
    return std::pair(before, along - before);
  };
  const auto [i, u] = locate(sheet.x(), width_, columns_);
  const auto [j, v] = locate(sheet.y(), height_, rows);
  const auto sample = [&](int column, int row) {
    return celsius_[static_cast<std::size_t>(std::min(row, rows - 1)) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(std::min(column, columns_ - 1))];
  };
  return (1 - v) * ((1 - u) * sample(i, j) + u * sample(i + 1, j)) +
         v * ((1 - u) * sample(i, j + 1) + u * sample(i + 1, j + 1));
}

}  // namespace vacuform
