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

SmoothInterpolation::SmoothInterpolation(const SheetGrid& from, const std::vector<Eigen::Vector2d>& rest,
                                         const std::vector<Eigen::Vector2d>& to)
    : grid_(from),
      columns_(static_cast<int>(from.columns.size())),
      rows_(static_cast<int>(from.rows.size())) {
  for (int k = 0; k < columns_ * rows_; ++k) {
    const Eigen::Vector2d home(from.columns[k % columns_], from.rows[k / columns_]);
    if (rest[k] == home) continue;
    moved_.push_back(k);
    off_.push_back(rest[k] - home);
  }
  // The edges of the window are where the middle row and the middle column come out from under the frame.
  std::vector<char> column_kinks(from.columns.size(), 0), row_kinks(from.rows.size(), 0);
  const auto mark = [&](std::vector<char>& kinks, int first, int stride) {
    const auto clamped = [&](std::size_t k) {
      return from.clamped[first + stride * static_cast<int>(k)] != 0;
    };
    for (std::size_t k = 1; k + 1 < kinks.size(); ++k)
      kinks[k] = clamped(k) && !(clamped(k - 1) && clamped(k + 1));
  };
  mark(column_kinks, rows_ / 2 * columns_, 1);
  mark(row_kinks, columns_ / 2, columns_);
  for (const auto& p : to)
    places_.push_back({line(from.columns, column_kinks, p.x()), line(from.rows, row_kinks, p.y())});
}

SmoothInterpolation::Line SmoothInterpolation::line(const std::vector<double>& lines,
                                                    const std::vector<char>& kink, double at) {
  const auto located = locate(lines, at);
  const int i = located.first;
  const double u = located.second;
  const int last = static_cast<int>(lines.size()) - 1;
  const double h = lines[i + 1] - lines[i], v = 1 - u;
  // Hermite's polynomials: values and slopes at the two lines.
  const double of_slope[2] = {u * v * v * h, -u * u * v * h};
  std::array<double, 4> w{0, v * v * (1 + 2 * u), u * u * (3 - 2 * u), 0};  // lines i - 1 to i + 2
  for (int side = 0; side < 2; ++side) {
    const int here = i + side;
    // The slope of the parabola through three lines is a mean of those of its two chords.
    double left = side, right = 1 - side;
    if (here > 0 && here < last && !kink[here]) {
      const double before = lines[here] - lines[here - 1], after = lines[here + 1] - lines[here];
      left = after / (before + after), right = before / (before + after);
    }
    const auto chord = [&](int k, double share) {  // from line k to the next
      if (share == 0) return;
      const double slope = of_slope[side] * share / (lines[k + 1] - lines[k]);
      w[k - i + 1] -= slope, w[k - i + 2] += slope;
    };
    chord(here - 1, left), chord(here, right);
  }
  // The stencil keeps inside the grid: what would be outside has no weight.
  const int first = std::clamp(i - 1, 0, std::max(0, last - 3));
  Line out{i, u, first, {}};
  for (int k = 0; k < 4; ++k)
    if (w[k] != 0) out.weight[i - 1 + k - first] = w[k];
  return out;
}

Points SmoothInterpolation::on_lines(const Points& values) const {
  Points out = values;
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const int v = moved_[k], i = v % columns_, j = v / columns_;
    const auto slope = [&](int index, int count, int stride, int axis) -> Eigen::Vector3d {
      const int a = index > 0 ? v - stride : v, b = index + 1 < count ? v + stride : v;
      const double length = axis == 0 ? grid_.columns[b % columns_] - grid_.columns[a % columns_]
                                      : grid_.rows[b / columns_] - grid_.rows[a / columns_];
      return (values.col(b) - values.col(a)) / length;
    };
    out.col(v) -= off_[k].x() * slope(i, columns_, 1, 0) + off_[k].y() * slope(j, rows_, columns_, 1);
  }
  return out;
}

Points SmoothInterpolation::operator()(const Points& values) const {
  const Points nodes = moved_.empty() ? values : on_lines(values);
  Points out(3, static_cast<Eigen::Index>(places_.size()));
  for (std::size_t p = 0; p < places_.size(); ++p) {
    const auto& [s, t] = places_[p];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        if (const double w = s.weight[i] * t.weight[j]; w != 0)
          sum += w * nodes.col((t.first + j) * columns_ + s.first + i);
    out.col(static_cast<Eigen::Index>(p)) = sum;
  }
  return out;
}

std::array<int, 4> SmoothInterpolation::corners(std::size_t point) const {
  const int corner = places_[point][1].at * columns_ + places_[point][0].at;
  return {corner, corner + 1, corner + columns_, corner + columns_ + 1};
}

std::array<double, 4> SmoothInterpolation::shares(std::size_t point) const {
  const double u = places_[point][0].part, v = places_[point][1].part;
  return {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
}

}  // namespace vacuform
