#include "worker/printing/ink_on_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/surface/scan_lines.hpp"

namespace vacuform {

double ink_on_charts(const std::vector<Segment>& charts, const Pattern& pattern) {
  const Eigen::Vector2d size = pattern.size_mm();
  const double cell = size.maxCoeff() / 1000;
  const int columns = std::max(1, static_cast<int>(std::ceil(size.x() / cell - 1e-9)));
  const int rows = std::max(1, static_cast<int>(std::ceil(size.y() / cell - 1e-9)));
  std::vector<std::uint8_t> on_chart(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (const Segment& chart : charts)
    for (const Triangle& triangle : chart.patch.triangles) {
      std::array<Eigen::Vector2d, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector2d& uv = chart.patch.uv[triangle[k]];
        corners[k] = {uv.x() / cell + 0.5 * columns, 0.5 * rows - uv.y() / cell};
      }
      scan_triangle(corners, columns, 0, rows, [&](int row, int begin, int end) {
        std::fill(on_chart.begin() + static_cast<std::ptrdiff_t>(row) * columns + begin,
                  on_chart.begin() + static_cast<std::ptrdiff_t>(row) * columns + end, std::uint8_t{1});
      });
    }

  const int channels = pattern.grayscale() ? 1 : 4;
  std::vector<float> line(static_cast<std::size_t>(columns) * static_cast<std::size_t>(channels));
  double all = 0, on = 0;
  for (int row = 0; row < rows; ++row) {
    pattern.sample_line({(0.5 - 0.5 * columns) * cell, (0.5 * rows - row - 0.5) * cell}, {cell, 0}, columns,
                        cell, line.data());
    for (int x = 0; x < columns; ++x) {
      const float* p = line.data() + static_cast<std::ptrdiff_t>(x) * channels;
      const double ink = channels == 1 ? p[0] : p[3] - (0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2]);
      all += ink;
      if (on_chart[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                   static_cast<std::size_t>(x)])
        on += ink;
    }
  }
  return all > 0 ? std::clamp(on / all, 0.0, 1.0) : 0;
}

}  // namespace vacuform
