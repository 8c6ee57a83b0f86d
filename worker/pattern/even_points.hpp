// Points at even distances along a closed line.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vacuform {

// The first of `count` points is the first of the line, which closes on itself and has at least two points.
inline std::vector<Eigen::Vector2d> even_points(const std::vector<Eigen::Vector2d>& line, int count) {
  const auto piece_at = [&](std::size_t i) { return Eigen::Vector2d(line[(i + 1) % line.size()] - line[i]); };
  double length = 0;
  for (std::size_t i = 0; i < line.size(); ++i) length += piece_at(i).norm();
  std::vector<Eigen::Vector2d> out;
  double passed = 0;
  std::size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const double wanted = length * k / count;
    double piece = piece_at(i).norm();
    while (i + 1 < line.size() && passed + piece <= wanted) {
      passed += piece, ++i;
      piece = piece_at(i).norm();
    }
    out.push_back(line[i] + (piece > 0 ? (wanted - passed) / piece : 0) * piece_at(i));
  }
  return out;
}

}  // namespace vacuform
