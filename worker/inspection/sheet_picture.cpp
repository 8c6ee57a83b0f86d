#include "worker/inspection/sheet_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/printing/colour_raster.hpp"
#include "worker/printing/sheet_raster.hpp"
#include "worker/printing/vector_raster.hpp"

namespace vacuform {

namespace {
constexpr std::array<float, 256> part_of_255 = [] {
  std::array<float, 256> parts{};
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = static_cast<float>(i) / 255;
  return parts;
}();
}  // namespace

SheetPicture::SheetPicture(const Finished& job, InkState state, double pixel_mm)
    : job_(job), pixel_mm_(pixel_mm), chart_(job.sheet.triangles, job.sheet.rest, job.flattening.triangles) {
  width_ = static_cast<int>(std::ceil(job.settings.sheet.width_mm / pixel_mm));
  height_ = static_cast<int>(std::ceil(job.settings.sheet.height_mm / pixel_mm));
  const auto ink = ink_of(job.print, job.surface, job.settings.print.ink_curve);
  const ColourRaster::Compensation compensation{ink ? &*ink : nullptr, state};
  if (job.print.vectors) {
    print_ = pixels_of(VectorRaster(*job.print.vectors, width_, height_, pixel_mm, false), 4);
  } else if (of_colours_alone(job)) {
    print_ = pixels_of(ColourRaster(*job.colours, width_, height_, pixel_mm, compensation, 1), 4);
  } else if (job.placement && !job.placement->elements.empty()) {
    Print size;
    size.width = width_, size.height = height_, size.pixel_mm = pixel_mm;
    const InkParts of_picture(job.pattern);
    print_ = pixels_of(SheetRaster(layers_of(*job.placement), &of_picture, size, job.pattern,
                                   static_cast<int>(25.4 / pixel_mm)),
                       job.pattern.grayscale() ? 1 : 4);
  }
  if (vacuform::over_colours(job))
    colours_ = pixels_of(ColourRaster(*job.colours, width_, height_, pixel_mm, compensation, 1), 4);
}

SheetPicture::Pixels SheetPicture::pixels_of(const RowSource& source, int channels) const {
  Pixels rgba;
  rgba.reserve(4 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int top = 0; top < height_; top += source.band_rows()) {
    const auto band = source.rows(top, std::min(top + source.band_rows(), height_));
    if (channels == 4) {
      rgba.insert(rgba.end(), band.begin(), band.end());
      continue;
    }
    for (const std::uint8_t gray : band)
      rgba.insert(rgba.end(), {0, 0, 0, static_cast<std::uint8_t>(255 - gray)});
  }
  return rgba;
}

Ink SheetPicture::sample(const Eigen::Vector2d& rest, double blur_mm) const {
  return over_colours(print_.empty() ? of_pattern(rest, blur_mm) : of_pixels(print_, rest), rest);
}

Ink SheetPicture::over_colours(const Ink& ink, const Eigen::Vector2d& rest) const {
  if (colours_.empty()) return ink;
  const Ink below = of_pixels(colours_, rest);
  const float through = (1 - ink.a) * below.a, a = ink.a + through;
  if (!(a > 0)) return {};
  const auto mixed = [&](float over, float under) { return (ink.a * over + through * under) / a; };
  return {mixed(ink.r, below.r), mixed(ink.g, below.g), mixed(ink.b, below.b), a};
}

// Bilinear, with pixels weighted by their opacity.
Ink SheetPicture::of_pixels(const Pixels& rgba, const Eigen::Vector2d& rest) const {
  const double x = rest.x() / pixel_mm_ + width_ / 2.0 - 0.5, y = height_ / 2.0 - rest.y() / pixel_mm_ - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  if (left >= 0 && top >= 0 && left + 1 < width_ && top + 1 < height_) {  // most of the sheet is bare
    const std::uint8_t* above = &rgba[4 * (static_cast<std::size_t>(top) * static_cast<std::size_t>(width_) +
                                           static_cast<std::size_t>(left))];
    const std::uint8_t* below = above + 4 * static_cast<std::ptrdiff_t>(width_);
    if ((above[3] | above[7] | below[3] | below[7]) == 0) return {};
  }
  float sum[4] = {0, 0, 0, 0};
  for (int j = top; j < top + 2; ++j)
    for (int i = left; i < left + 2; ++i) {
      if (i < 0 || j < 0 || i >= width_ || j >= height_) continue;
      const std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) +
                                         static_cast<std::size_t>(i))];
      const double weight = (1 - std::abs(x - i)) * (1 - std::abs(y - j));
      const float opacity = static_cast<float>(weight) * part_of_255[p[3]];
      for (int k = 0; k < 3; ++k) sum[k] += opacity * part_of_255[p[k]];
      sum[3] += opacity;
    }
  if (!(sum[3] > 0)) return {};
  return {sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3], std::min(1.0f, sum[3])};
}

Ink SheetPicture::of_pattern(const Eigen::Vector2d& rest, double blur_mm) const {
  const auto at = chart_.find(rest);
  if (!at) return {};
  const auto& region = job_.flattening.triangles;
  const auto row = std::lower_bound(region.begin(), region.end(), at->triangle) - region.begin();
  const auto& uv = job_.print.pattern_uv[static_cast<std::size_t>(row)];
  return job_.pattern.sample(at->weights[0] * uv[0] + at->weights[1] * uv[1] + at->weights[2] * uv[2],
                             blur_mm);
}

}  // namespace vacuform
