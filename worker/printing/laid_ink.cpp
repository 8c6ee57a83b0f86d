#include "worker/printing/laid_ink.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/numerics/plane.hpp"
#include "worker/surface/scan_lines.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
constexpr double least_pixel_mm = 0.25, most_pixels = 2000;
constexpr int faint = 8;  // of 255: below it is the rim of a soft edge

std::uint8_t darkness(const std::uint8_t* p, int channels) {
  if (channels == 1) return static_cast<std::uint8_t>(255 - p[0]);
  return static_cast<std::uint8_t>(
      std::lround(p[3] * (1 - (0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]) / 255)));
}

}  // namespace

PrintGrid LaidInk::grid_of(double width_mm, double height_mm) {
  const double pixel_mm = std::max(least_pixel_mm, std::max(width_mm, height_mm) / most_pixels);
  return {static_cast<int>(std::ceil(width_mm / pixel_mm)), static_cast<int>(std::ceil(height_mm / pixel_mm)),
          pixel_mm};
}

LaidInk::LaidInk(const RowSource& source, const PrintGrid& grid) : grid_(grid) {
  ink_.reserve(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  const int channels = source.channels();
  for (int top = 0; top < grid.height; top += source.band_rows()) {
    const auto band = source.rows(top, std::min(top + source.band_rows(), grid.height));
    for (std::size_t i = 0; i < band.size(); i += static_cast<std::size_t>(channels))
      ink_.push_back(darkness(&band[i], channels));
  }
}

void LaidInk::add(const LaidInk& other) {
  std::transform(ink_.begin(), ink_.end(), other.ink_.begin(), ink_.begin(),
                 [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); });
}

double LaidInk::share_on(const ChartedSurface& charted) const {
  const InkedSurface& surface = charted.surface();
  double all = 0, on = 0;
  for (std::size_t t = 0; t < surface.triangles().size(); ++t) {
    std::array<Vector2d, 3> corners;
    std::array<Eigen::Vector3d, 3> formed;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(surface.triangles()[t][k]);
      corners[k] = {surface.rest()[v].x() / grid_.pixel_mm + 0.5 * grid_.width,
                    0.5 * grid_.height - surface.rest()[v].y() / grid_.pixel_mm};
      formed[k] = surface.inked()[v];
    }
    const Vector2d a = corners[1] - corners[0], b = corners[2] - corners[0];
    const double flat = std::abs(cross(a, b));
    std::int64_t sum = 0;
    scan_triangle(corners, grid_.width, 0, grid_.height, [&](int row, int begin, int end) {
      const auto first = ink_.begin() + static_cast<std::ptrdiff_t>(row) * grid_.width;
      for (auto p = first + begin; p < first + end; ++p) sum += *p;
    });
    if (sum == 0 || !(flat > 0)) continue;
    const double area = (formed[1] - formed[0]).cross(formed[2] - formed[0]).norm() / flat;
    all += area * static_cast<double>(sum);
    if (charted.on_chart(static_cast<int>(t))) on += area * static_cast<double>(sum);
  }
  return all > 0 ? on / all : 1;
}

bool LaidInk::any_in(const Eigen::AlignedBox2d& rest) const {
  const auto column = [&](double x) {
    return std::clamp(static_cast<int>(std::floor(x / grid_.pixel_mm + 0.5 * grid_.width)), 0,
                      grid_.width - 1);
  };
  const auto row = [&](double y) {
    return std::clamp(static_cast<int>(std::floor(0.5 * grid_.height - y / grid_.pixel_mm)), 0,
                      grid_.height - 1);
  };
  for (int j = row(rest.max().y()); j <= row(rest.min().y()); ++j)
    for (int i = column(rest.min().x()); i <= column(rest.max().x()); ++i)
      if (ink_[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid_.width) +
               static_cast<std::size_t>(i)] >= faint)
        return true;
  return false;
}

bool LaidInk::any_near(const Vector2d& rest, double mm) const {
  const double x = rest.x() / grid_.pixel_mm + 0.5 * grid_.width - 0.5,
               y = 0.5 * grid_.height - rest.y() / grid_.pixel_mm - 0.5, reach = mm / grid_.pixel_mm;
  if (!std::isfinite(x + y)) return false;
  for (int j = std::max(0, static_cast<int>(std::ceil(y - reach)));
       j <= std::min(grid_.height - 1, static_cast<int>(std::floor(y + reach))); ++j)
    for (int i = std::max(0, static_cast<int>(std::ceil(x - reach)));
         i <= std::min(grid_.width - 1, static_cast<int>(std::floor(x + reach))); ++i)
      if ((i - x) * (i - x) + (j - y) * (j - y) < reach * reach &&
          ink_[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid_.width) +
               static_cast<std::size_t>(i)] >= faint)
        return true;
  return false;
}

}  // namespace vacuform
