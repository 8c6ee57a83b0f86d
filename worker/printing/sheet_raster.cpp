#include "worker/printing/sheet_raster.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "worker/printing/raster_bands.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/scan_lines.hpp"

namespace vacuform {

using Eigen::Matrix2d;
using Eigen::Vector2d;

std::vector<RasterPatch> patches_of(const Placement& placement) {
  constexpr int unplaced = -1;
  std::vector<RasterPatch> patches;
  for (const Segment& chart : placement.charts)
    patches.push_back({&chart.patch, placement.elements.empty() ? RasterPatch::whole : unplaced, {}});
  for (const PlacedElement& element : placement.elements)
    patches.push_back({&element.patch, element.element, {}});
  return patches;
}

int edge_samples(const PrintGrid& grid) {
  const auto dpi = static_cast<int>(std::lround(25.4 / grid.pixel_mm));
  return std::clamp((600 + dpi - 1) / dpi, 2, 4);
}

SheetRaster::SheetRaster(const std::vector<RasterPatch>& patches, const InkParts* parts,
                         const Pattern& pattern, const PrintGrid& grid, int samples)
    : pattern_(pattern),
      parts_(parts),
      width_(grid.width),
      height_(grid.height),
      channels_(pattern.grayscale() ? 1 : 4),
      samples_(samples),
      band_(band_rows_of(grid.width)) {
  const double n = samples_;
  Vector2d low(width_, height_), high(0, 0);
  for (const RasterPatch& each : patches)
    for (std::size_t t = 0; t < each.patch->triangles.size(); ++t) {
      const Triangle& corners = each.patch->triangles[t];
      Piece piece;
      std::array<Vector2d, 3> uv;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector2d& st = each.patch->rest[corners[k]];
        const Vector2d pixel(st.x() / grid.pixel_mm + 0.5 * width_, 0.5 * height_ - st.y() / grid.pixel_mm);
        piece.corners[k] = n * pixel;
        uv[k] = each.patch->uv[corners[k]];
        low = low.cwiseMin(pixel);
        high = high.cwiseMax(pixel);
      }
      Matrix2d place, drawn;
      place << piece.corners[1] - piece.corners[0], piece.corners[2] - piece.corners[0];
      drawn << uv[1] - uv[0], uv[2] - uv[0];
      const Matrix2d map = drawn * place.inverse();
      if (!map.allFinite() || !piece.corners[0].allFinite()) continue;
      piece.across = map.col(0);
      piece.down = map.col(1);
      piece.origin = uv[0] - map * piece.corners[0];
      // A unit square has the variance of a disk of diameter 2 / sqrt(3); a stretched one is treated as round, with the
      // same mean variance.
      piece.blur = 2 / std::sqrt(3.0) * map.norm() / std::sqrt(2.0);
      piece.gain = each.gain.empty() ? 1.0f : static_cast<float>(each.gain[t]);
      piece.part = each.part;
      pieces_.push_back(piece);
    }
  box_ = box_between(low, high, width_, height_);
  of_band_ = pieces_by_band(pieces_, n, height_, band_);
}

void SheetRaster::scan(const Piece& piece, int first_row, int last_row, int top,
                       std::vector<float>& sums) const {
  const int n = samples_;
  const Vector2d reach = pattern_.size_mm() / 2 + Vector2d::Constant(2 * piece.blur) +
                         2 * pattern_.size_mm().cwiseQuotient(pattern_.size_pixels().cast<double>());
  constexpr int run = 512;
  float line[4 * run];
  scan_triangle(piece.corners, width_ * n, first_row * n, last_row * n, [&](int row, int begin, int end) {
    const Vector2d start = piece.origin + (row + 0.5) * piece.down;
    // Most of a large chart may lie off a small drawing: that part is skipped.
    double from = begin, to = end;
    for (int k = 0; k < 2; ++k) {
      const double a = piece.across[k], at = start[k];
      if (std::abs(a) < 1e-12) {
        if (std::abs(at) > reach[k]) return;
        continue;
      }
      const double x1 = (-reach[k] - at) / a, x2 = (reach[k] - at) / a;
      from = std::max(from, std::min(x1, x2) - 1);
      to = std::min(to, std::max(x1, x2) + 1);
    }
    if (!(from < to)) return;
    begin = std::max(begin, static_cast<int>(from));
    end = std::min(end, static_cast<int>(std::ceil(to)));
    float* out =
        sums.data() + static_cast<std::ptrdiff_t>(row / n - top) * (box_.right - box_.left) * channels_;
    for (int x = begin; x < end; x += run) {
      const int count = std::min(run, end - x);
      const Vector2d from_here = start + (x + 0.5) * piece.across;
      pattern_.sample_line(from_here, piece.across, count, piece.blur, line);
      if (piece.part != RasterPatch::whole)
        for (int k = 0; k < count; ++k)
          if (!parts_->holds(piece.part, from_here + k * piece.across))
            std::fill_n(line + k * channels_, channels_, 0.0f);
      for (int k = 0; k < count; ++k) {
        float* sum = out + static_cast<std::ptrdiff_t>((x + k) / n - box_.left) * channels_;
        if (piece.gain != 1)
          sum[0] += std::min(1.0f, piece.gain * line[k]);
        else
          for (int c = 0; c < channels_; ++c) sum[c] += line[k * channels_ + c];
      }
    }
  });
}

std::vector<std::uint8_t> SheetRaster::rows(int top, int bottom) const {
  const std::size_t columns = static_cast<std::size_t>(width_), n = static_cast<std::size_t>(channels_);
  std::vector<std::uint8_t> pixels(columns * static_cast<std::size_t>(bottom - top) * n,
                                   channels_ == 1 ? 255 : 0);
  const auto& pieces = of_band_[top / band_];
  if (pieces.empty()) return pixels;
  const int box_width = box_.right - box_.left;
  std::vector<float> sums(static_cast<std::size_t>(box_width) * static_cast<std::size_t>(bottom - top) * n,
                          0.0f);
  const float scale = 1.0f / static_cast<float>(samples_ * samples_);
  in_parallel(top, bottom, [&](int first, int last) {
    for (const int i : pieces) scan(pieces_[i], first, last, top, sums);
    for (int y = first; y < last; ++y) {
      const float* sum = sums.data() + static_cast<std::ptrdiff_t>(y - top) * box_width * channels_;
      std::uint8_t* out =
          pixels.data() + (static_cast<std::ptrdiff_t>(y - top) * width_ + box_.left) * channels_;
      for (int x = 0; x < box_width; ++x, sum += channels_, out += channels_) {
        const auto byte = [](float v) {
          return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
        };
        if (channels_ == 1) {
          out[0] = byte(1 - sum[0] * scale);
        } else if (sum[3] > 0) {
          for (int c = 0; c < 3; ++c) out[c] = byte(sum[c] / sum[3]);
          out[3] = byte(sum[3] * scale);
        }
      }
    }
  });
  return pixels;
}

}  // namespace vacuform
