#include "worker/forming/heat/scattered.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "worker/numerics/dense.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

constexpr std::size_t most_knots = 400;

// The mean of the points of each square cell, in a fixed order.
std::vector<MeasuredPoint> merged(const std::vector<MeasuredPoint>& points, double cell_mm) {
  struct Sum {
    Eigen::Vector2d sheet = Eigen::Vector2d::Zero();
    double celsius = 0, count = 0;
  };
  std::map<std::pair<long, long>, Sum> cells;
  for (const MeasuredPoint& p : points) {
    Sum& sum = cells[{std::lround(p.sheet.x() / cell_mm), std::lround(p.sheet.y() / cell_mm)}];
    sum.sheet += p.sheet, sum.celsius += p.celsius, sum.count += 1;
  }
  std::vector<MeasuredPoint> out;
  for (const auto& [cell, sum] : cells) out.push_back({sum.sheet / sum.count, sum.celsius / sum.count});
  return out;
}

double kernel(double squared_distance) {
  return squared_distance > 0 ? squared_distance * std::log(squared_distance) : 0;
}

}  // namespace

TemperatureField through_points(const std::vector<MeasuredPoint>& given, double width_mm, double height_mm) {
  std::vector<MeasuredPoint> points = merged(given, 0.5);
  if (points.size() > most_knots) points = merged(points, std::max(width_mm, height_mm) / 20);
  const double scale = 2 / std::max(width_mm, height_mm);  // to about [-1, 1], for the sake of conditioning

  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + 3, n + 3);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n + 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const MeasuredPoint& p = points[i];
    for (Eigen::Index j = 0; j < n; ++j)
      A(i, j) = kernel((scale * (p.sheet - points[j].sheet)).squaredNorm());
    A(i, n) = A(n, i) = 1;
    A(i, n + 1) = A(n + 1, i) = scale * p.sheet.x();
    A(i, n + 2) = A(n + 2, i) = scale * p.sheet.y();
    b[i] = p.celsius;
  }
  // Points on one line leave the slope across it open: the solution of least norm has none.
  const Eigen::VectorXd x = shortest_least_squares(A, b);

  double least = points.front().celsius, most = least;
  for (const MeasuredPoint& p : points) least = std::min(least, p.celsius), most = std::max(most, p.celsius);
  const auto samples = [](double mm) {
    return std::clamp(static_cast<int>(std::lround(mm / 5)) + 1, 2, 121);
  };
  const int columns = samples(width_mm), rows = samples(height_mm);
  std::vector<double> celsius(static_cast<std::size_t>(columns * rows));
  in_parallel(0, rows, [&](int begin, int end) {
    for (int row = begin; row < end; ++row)
      for (int column = 0; column < columns; ++column) {
        const Eigen::Vector2d at((static_cast<double>(column) / (columns - 1) - 0.5) * width_mm * scale,
                                 (static_cast<double>(row) / (rows - 1) - 0.5) * height_mm * scale);
        double value = x[n] + x[n + 1] * at.x() + x[n + 2] * at.y();
        for (Eigen::Index i = 0; i < n; ++i)
          value += x[i] * kernel((at - scale * points[i].sheet).squaredNorm());
        celsius[row * columns + column] = std::clamp(value, least, most);
      }
  });
  return {width_mm, height_mm, columns, std::move(celsius)};
}

}  // namespace vacuform
