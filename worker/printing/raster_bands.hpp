// The triangles of a raster, sorted by the bands of rows that they touch. Internal to worker/printing.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/printing/row_source.hpp"

namespace vacuform {

// Rows that are made at a time: about a million pixels.
inline int band_rows_of(int width) { return std::clamp(1'000'000 / width, 16, 256); }

// From a coordinate to a pixel in [0, limit].
inline int pixel_at(double x, int limit) {
  return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(limit)));
}

// The pixels between two corners, at least one.
inline PixelBox box_between(const Eigen::Vector2d& low, const Eigen::Vector2d& high, int width, int height) {
  PixelBox box{pixel_at(std::floor(low.x()), width - 1), pixel_at(std::floor(low.y()), height - 1), 0, 0};
  box.right = std::max(box.left + 1, pixel_at(std::ceil(high.x()), width));
  box.bottom = std::max(box.top + 1, pixel_at(std::ceil(high.y()), height));
  return box;
}

// For each band of `rows` rows the pieces that may touch it, ascending. A piece has `corners`, in samples of which
// `samples` make up a side of a pixel.
template <class Piece>
std::vector<std::vector<int>> pieces_by_band(const std::vector<Piece>& pieces, double samples, int height,
                                             int rows) {
  std::vector<std::vector<int>> bands(static_cast<std::size_t>((height + rows - 1) / rows));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto& c = pieces[i].corners;
    const double top = std::min({c[0].y(), c[1].y(), c[2].y()}) / samples,
                 bottom = std::max({c[0].y(), c[1].y(), c[2].y()}) / samples;
    const int first = pixel_at(top - 1, height - 1) / rows, last = pixel_at(bottom + 1, height - 1) / rows;
    for (int b = first; b <= last; ++b) bands[b].push_back(static_cast<int>(i));
  }
  return bands;
}

}  // namespace vacuform
