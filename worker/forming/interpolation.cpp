#include "worker/forming/interpolation.hpp"

#include <algorithm>
#include <utility>

namespace vacuform {

namespace {
// The line before a coordinate, and the fraction of the way to the next.
std::pair<int, double> locate(const std::vector<double>& lines, double at) {
  const auto next =
      std::clamp(std::upper_bound(lines.begin(), lines.end(), at), lines.begin() + 1, lines.end() - 1);
  return {static_cast<int>(next - lines.begin()) - 1, (at - *(next - 1)) / (*next - *(next - 1))};
}
}  // namespace

Interpolation::Interpolation(const SheetGrid& from, const SheetGrid& to)
    : columns_(static_cast<int>(from.columns.size())) {
  for (const auto& rest : to.rest) {
    const auto [i, u] = locate(from.columns, rest.x());
    const auto [j, v] = locate(from.rows, rest.y());
    cells_.push_back({j * columns_ + i, u, v});
  }
}

Eigen::Vector3d Interpolation::at(const Points& values, std::size_t vertex) const {
  const auto& [corner, u, v] = cells_[vertex];
  const int above = corner + columns_;
  return (1 - v) * ((1 - u) * values.col(corner) + u * values.col(corner + 1)) +
         v * ((1 - u) * values.col(above) + u * values.col(above + 1));
}

}  // namespace vacuform
