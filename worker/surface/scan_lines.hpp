// Converts triangles to scan lines by the shared-edge rule: a sample belongs to a triangle if its centre lies inside.
// If two triangles share an edge, exactly one owns each sample on it, because both compute the crossing of the edge
// with the scan line from the same end points in the same order.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace vacuform {

// Calls span(row, begin, end) for each of the rows [first_row, last_row) in which the triangle owns samples,
// columns [begin, end) within [0, columns). Sample (column, row) has its centre at (column + 0.5, row + 0.5).
// Either orientation of the triangle is allowed; a triangle with a coordinate that is not finite owns nothing.
template <class Span>
void scan_triangle(const std::array<Eigen::Vector2d, 3>& p, int columns, int first_row, int last_row,
                   Span&& span) {
  if (!p[0].allFinite() || !p[1].allFinite() || !p[2].allFinite()) return;
  const double low = std::min({p[0].y(), p[1].y(), p[2].y()}),
               high = std::max({p[0].y(), p[1].y(), p[2].y()});
  if (low > last_row || high < first_row) return;
  const int begin_row =
      std::max(first_row, static_cast<int>(std::ceil(std::max(low - 0.5, first_row - 1.0))));
  const int end_row = std::min(last_row, static_cast<int>(std::ceil(std::min(high - 0.5, last_row + 1.0))));
  for (int row = begin_row; row < end_row; ++row) {
    const double y = row + 0.5;
    double x[2];
    int crossings = 0;
    for (int e = 0; e < 3; ++e) {
      const Eigen::Vector2d* a = &p[e];
      const Eigen::Vector2d* b = &p[(e + 1) % 3];
      if (a->y() > b->y()) std::swap(a, b);
      if (!(a->y() <= y && y < b->y()) || crossings == 2) continue;
      x[crossings++] = a->x() + (y - a->y()) * ((b->x() - a->x()) / (b->y() - a->y()));
    }
    if (crossings < 2) continue;
    if (x[0] > x[1]) std::swap(x[0], x[1]);
    const double left = std::ceil(std::clamp(x[0] - 0.5, -1.0, columns + 1.0));
    const double right = std::ceil(std::clamp(x[1] - 0.5, -1.0, columns + 1.0));
    const int begin = std::max(0, static_cast<int>(left)), end = std::min(columns, static_cast<int>(right));
    if (begin < end) span(row, begin, end);
  }
}

}  // namespace vacuform
