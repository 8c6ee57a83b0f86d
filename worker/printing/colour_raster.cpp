#include "worker/printing/colour_raster.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "worker/printing/raster_bands.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/scan_lines.hpp"

namespace vacuform {

namespace {
// Rows of pixels that are made together. They are the same for any number of threads, and so is the walk over the scan.
constexpr int strip_rows = 8;
}  // namespace

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

ColourRaster::ColourRaster(const SheetColours& colours, int width, int height, double pixel_mm,
                           Compensation compensation, int samples)
    : colours_(colours),
      compensation_(compensation),
      width_(width),
      height_(height),
      samples_(samples),
      band_(band_rows_of(width)) {
  const double n = samples;
  const FormedSheet& sheet = colours.sheet();
  Vector2d low(width_, height_), high(0, 0);
  for (const int t : colours.triangles()) {
    Piece piece;
    std::array<Vector3d, 3> formed;
    Vector3d ratio = Vector3d::Ones();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(sheet.triangles[static_cast<std::size_t>(t)][k]);
      const Vector2d pixel(sheet.rest[v].x() / pixel_mm + 0.5 * width_,
                           0.5 * height_ - sheet.rest[v].y() / pixel_mm);
      piece.corners[k] = n * pixel;
      formed[k] = sheet.formed[v];
      if (compensation.ink) ratio[static_cast<Eigen::Index>(k)] = compensation.ink->area_ratios[v];
      low = low.cwiseMin(pixel);
      high = high.cwiseMax(pixel);
    }
    Matrix2d place;
    place << piece.corners[1] - piece.corners[0], piece.corners[2] - piece.corners[0];
    Eigen::Matrix<double, 3, 2> formed_sides;
    formed_sides << formed[1] - formed[0], formed[2] - formed[0];
    const Eigen::Matrix<double, 3, 2> map = formed_sides * place.inverse();
    if (!map.allFinite() || !piece.corners[0].allFinite()) continue;
    piece.across = map.col(0);
    piece.down = map.col(1);
    piece.origin = formed[0] - map * piece.corners[0];
    const Eigen::RowVector2d change =
        Eigen::RowVector2d(ratio[1] - ratio[0], ratio[2] - ratio[0]) * place.inverse();
    piece.ratio_across = change.x();
    piece.ratio_down = change.y();
    piece.ratio = ratio[0] - change * piece.corners[0];
    piece.start = colours.nearest_triangle(sheet.triangles[static_cast<std::size_t>(t)][0]);
    pieces_.push_back(piece);
  }
  box_ = box_between(low, high, width_, height_);
  of_band_ = pieces_by_band(pieces_, n, height_, band_);
}

void ColourRaster::scan(const Piece& piece, int first_row, int last_row, int top,
                        std::vector<float>& sums) const {
  const int n = samples_;
  const ColourReach& reach = colours_.reach();
  ColourWalk walk(colours_.surface(), piece.across, piece.down, piece.start), at_begin = walk;
  scan_triangle(piece.corners, width_ * n, first_row * n, last_row * n, [&](int row, int begin, int end) {
    float* out = sums.data() + static_cast<std::ptrdiff_t>(row / n - top) * (box_.right - box_.left) * 4;
    const Vector3d start = piece.origin + (row + 0.5) * piece.down;
    const double ratio = piece.ratio + (row + 0.5) * piece.ratio_down;
    walk = at_begin;
    const int first = std::max(begin, box_.left * n);
    for (int x = first; x < std::min(end, box_.right * n); ++x) {
      const auto found = walk.at(start + (x + 0.5) * piece.across, reach.end_mm());
      if (x == first) at_begin = walk;
      if (!found) continue;
      const float share = static_cast<float>(reach.share(found->distance_mm));
      float* sum = out + static_cast<std::ptrdiff_t>(x / n - box_.left) * 4;
      const Eigen::Vector3f linear =
          inked(found->linear, static_cast<float>(ratio + (x + 0.5) * piece.ratio_across));
      for (int c = 0; c < 3; ++c) sum[c] += share * linear[c];
      sum[3] += share;
    }
  });
}

std::vector<ColourRaster::Origin> ColourRaster::origins(int row, int first, int step) const {
  const int n = samples_;
  const ColourReach& reach = colours_.reach();
  std::vector<Origin> out(static_cast<std::size_t>(std::max(0, (width_ - first + step - 1) / step)));
  for (const int i : of_band_[static_cast<std::size_t>(row / band_)]) {
    const Piece& piece = pieces_[static_cast<std::size_t>(i)];
    ColourWalk walk(colours_.surface(), piece.across, piece.down, piece.start);
    scan_triangle(piece.corners, width_ * n, row * n, (row + 1) * n, [&](int y, int begin, int end) {
      const Vector3d start = piece.origin + (y + 0.5) * piece.down;
      for (int x = begin; x < end; ++x) {
        const int after = x / n - first;
        if (after < 0 || after % step != 0) continue;
        const auto found = walk.at(start + (x + 0.5) * piece.across, reach.end_mm());
        if (!found) continue;
        Origin& origin = out[static_cast<std::size_t>(after / step)];
        const double share = reach.share(found->distance_mm);
        origin.scan += share * found->place;
        origin.share += share;
      }
    });
  }
  for (Origin& origin : out)
    if (origin.share > 0) origin.scan /= origin.share, origin.share /= n * n;
  return out;
}

Eigen::Vector3f ColourRaster::inked(const Eigen::Vector3f& linear, float area_ratio) const {
  if (!compensation_.ink) return linear;
  return compensation_.state == InkState::printed ? compensation_.ink->printed(linear, area_ratio)
                                                  : compensation_.ink->shown(linear, area_ratio);
}

std::vector<std::uint8_t> ColourRaster::rows(int top, int bottom) const {
  std::vector<std::uint8_t> pixels(
      4 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(bottom - top), 0);
  const auto& pieces = of_band_[static_cast<std::size_t>(top / band_)];
  if (pieces.empty()) return pixels;
  const int box_width = box_.right - box_.left;
  std::vector<float> sums(4 * static_cast<std::size_t>(box_width) * static_cast<std::size_t>(bottom - top),
                          0.0f);
  const float scale = 1.0f / static_cast<float>(samples_ * samples_);
  in_parallel(0, (bottom - top + strip_rows - 1) / strip_rows, [&](int first_strip, int last_strip) {
    for (int strip = first_strip; strip < last_strip; ++strip) {
      const int first = top + strip * strip_rows, last = std::min(first + strip_rows, bottom);
      for (const int i : pieces) scan(pieces_[static_cast<std::size_t>(i)], first, last, top, sums);
    }
    for (int y = top + first_strip * strip_rows; y < std::min(top + last_strip * strip_rows, bottom); ++y) {
      const float* sum = sums.data() + static_cast<std::ptrdiff_t>(y - top) * box_width * 4;
      std::uint8_t* out = pixels.data() + (static_cast<std::ptrdiff_t>(y - top) * width_ + box_.left) * 4;
      for (int x = 0; x < box_width; ++x, sum += 4, out += 4) {
        if (!(sum[3] > 0)) continue;
        for (int c = 0; c < 3; ++c)
          out[c] = static_cast<std::uint8_t>(std::lround(srgb_from_linear(sum[c] / sum[3]) * 255));
        out[3] = static_cast<std::uint8_t>(std::lround(std::min(1.0f, sum[3] * scale) * 255));
      }
    }
  });
  return pixels;
}

}  // namespace vacuform
