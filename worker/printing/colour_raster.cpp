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
constexpr int strip_rows = 16;
}  // namespace

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

ColourRaster::ColourRaster(const SheetColours& colours, const PrintGrid& grid, Compensation compensation,
                           int samples)
    : colours_(colours),
      compensation_(compensation),
      width_(grid.width),
      height_(grid.height),
      samples_(samples),
      band_(band_rows_of(grid.width)) {
  const double n = samples;
  const FormedSheet& sheet = colours.sheet();
  Vector2d low(width_, height_), high(0, 0);
  for (const int t : colours.triangles()) {
    Piece piece;
    std::array<Vector3d, 3> formed;
    Vector3d ratio = Vector3d::Ones();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(sheet.triangles[t][k]);
      const Vector2d pixel(sheet.rest[v].x() / grid.pixel_mm + 0.5 * width_,
                           0.5 * height_ - sheet.rest[v].y() / grid.pixel_mm);
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
    piece.start = colours.nearest_triangle(sheet.triangles[t][0]);
    pieces_.push_back(piece);
  }
  box_ = box_between(low, high, width_, height_);
  of_band_ = pieces_by_band(pieces_, n, height_, band_);
}

// Rows of pixels: the sums of the colours of their places, each times its share of full colour, and of the shares.
struct ColourRaster::Strip {
  int left, width, top, bottom;  // of the pixels
  std::vector<std::array<float, 4>> sums;

  Strip(const PixelBox& box, int from, int to)
      : left(box.left),
        width(box.right - box.left),
        top(from),
        bottom(to),
        sums(static_cast<std::size_t>(width) * static_cast<std::size_t>(to - from)) {}
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y - top) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x - left);
  }
};

template <class Wanted>
void ColourRaster::add(const Piece& piece, int places, const Wanted& wanted, Strip& strip) const {
  const double step = static_cast<double>(samples_) / places;
  const Vector3d across = step * piece.across, down = step * piece.down;
  std::array<Vector2d, 3> corners = piece.corners;
  for (Vector2d& corner : corners) corner /= step;
  const ColourReach& reach = colours_.reach();
  const float part = 1.0f / static_cast<float>(places * places);
  ColourWalk walk(colours_.surface(), across, down, piece.start);
  int at_begin = piece.start;  // the triangle at the begin of the row before
  scan_triangle(
      corners, width_ * places, strip.top * places, strip.bottom * places, [&](int row, int begin, int end) {
        const Vector3d start = piece.origin + (row + 0.5) * down;
        const double ratio = piece.ratio + (row + 0.5) * step * piece.ratio_down;
        walk.go_to(at_begin);
        bool first = true;
        for (int x = std::max(begin, strip.left * places);
             x < std::min(end, (strip.left + strip.width) * places); ++x) {
          const std::size_t pixel = strip.at(x / places, row / places);
          if (!wanted(pixel)) continue;
          const auto found = walk.at(start + (x + 0.5) * across, reach.end_mm());
          if (first) at_begin = walk.triangle(), first = false;
          if (!found) continue;
          const float share = part * static_cast<float>(reach.share(found->distance_mm));
          const Eigen::Vector3f linear =
              inked(found->linear, static_cast<float>(ratio + (x + 0.5) * step * piece.ratio_across));
          std::array<float, 4>& sum = strip.sums[pixel];
          for (int c = 0; c < 3; ++c) sum[c] += share * linear[c];
          sum[3] += share;
        }
      });
}

// The pixels of a strip that need more than one place: those that are partly on coloured triangles, those that fade, and
// those with another colour than a pixel beside them.
std::vector<char> ColourRaster::borders(const Strip& strip, const std::vector<int>& pieces) const {
  std::vector<char> border(strip.sums.size(), 0), inside(strip.sums.size(), 0);
  const int n = samples_;
  for (const int i : pieces)
    scan_triangle(pieces_[i].corners, width_ * n, strip.top * n, strip.bottom * n,
                  [&](int row, int begin, int end) {
                    for (int x = std::max(begin, strip.left * n);
                         x < std::min(end, (strip.left + strip.width) * n); ++x)
                      ++inside[strip.at(x / n, row / n)];
                  });
  const auto alike = [](const std::array<float, 4>& a, const std::array<float, 4>& b) {
    constexpr float least = 0.01f, most_share = 0.1f;  // in linear light
    for (std::size_t c = 0; c < 3; ++c)
      if (std::abs(a[c] - b[c]) > least + most_share * std::min(a[c], b[c])) return false;
    return true;
  };
  for (int y = strip.top; y < strip.bottom; ++y)
    for (int x = strip.left; x < strip.left + strip.width; ++x) {
      const std::size_t at = strip.at(x, y);
      const auto& here = strip.sums[at];
      if ((inside[at] > 0 && inside[at] < n * n) || (here[3] > 0 && here[3] < 1)) border[at] = 1;
      const bool last = x + 1 == strip.left + strip.width;
      const auto compare = [&](std::size_t other) {
        if (!alike(here, strip.sums[other])) border[at] = border[other] = 1;
      };
      if (!last) compare(at + 1);
      if (y + 1 == strip.bottom) continue;
      const std::size_t below = strip.at(x, y + 1);
      compare(below);
      if (!last) compare(below + 1);
      if (x > strip.left) compare(below - 1);
    }
  return border;
}

std::vector<ColourRaster::Origin> ColourRaster::origins(int row, int first, int step) const {
  const int n = samples_;
  const ColourReach& reach = colours_.reach();
  std::vector<Origin> out(static_cast<std::size_t>(std::max(0, (width_ - first + step - 1) / step)));
  for (const int i : of_band_[row / band_]) {
    const Piece& piece = pieces_[i];
    ColourWalk walk(colours_.surface(), piece.across, piece.down, piece.start);
    scan_triangle(piece.corners, width_ * n, row * n, (row + 1) * n, [&](int y, int begin, int end) {
      const Vector3d start = piece.origin + (y + 0.5) * piece.down;
      for (int x = begin; x < end; ++x) {
        const int after = x / n - first;
        if (after < 0 || after % step != 0) continue;
        const auto found = walk.at(start + (x + 0.5) * piece.across, reach.end_mm());
        if (!found) continue;
        Origin& origin = out[after / step];
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
  const auto& pieces = of_band_[top / band_];
  if (pieces.empty()) return pixels;
  const auto make = [&](int first, int last) {
    // First one place for each pixel, with one more row on each side to compare with; then more places at borders.
    Strip strip(box_, std::max(first - 1, 0), std::min(last + 1, height_));
    for (const int i : pieces)
      add(
          pieces_[i], 1, [](std::size_t) { return true; }, strip);
    if (samples_ > 1) {
      const std::vector<char> border = borders(strip, pieces);
      for (std::size_t i = 0; i < border.size(); ++i)
        if (border[i]) strip.sums[i] = {};
      for (const int i : pieces)
        add(
            pieces_[i], samples_, [&](std::size_t pixel) { return border[pixel] != 0; }, strip);
    }
    for (int y = first; y < last; ++y) {
      const std::array<float, 4>* sum = &strip.sums[strip.at(box_.left, y)];
      std::uint8_t* out = pixels.data() + (static_cast<std::ptrdiff_t>(y - top) * width_ + box_.left) * 4;
      for (int x = box_.left; x < box_.right; ++x, ++sum, out += 4) {
        const float share = (*sum)[3];
        if (!(share > 0)) continue;
        for (std::size_t c = 0; c < 3; ++c) out[c] = srgb_byte((*sum)[c] / share);
        out[3] = static_cast<std::uint8_t>(std::lround(std::min(1.0f, share) * 255));
      }
    }
  };
  each_in_parallel(0, (bottom - top + strip_rows - 1) / strip_rows, [&](int strip) {
    const int first = top + strip * strip_rows;
    make(first, std::min(first + strip_rows, bottom));
  });
  return pixels;
}

}  // namespace vacuform
