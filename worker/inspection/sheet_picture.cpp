#include "worker/inspection/sheet_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace vacuform {

namespace {
constexpr std::array<float, 256> part_of_255 = [] {
  std::array<float, 256> parts{};
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = static_cast<float>(i) / 255;
  return parts;
}();

// What is printed in several steps has a colour for each of them, and a picture its own.
std::optional<Colour> tint_of(const Layer& layer, const Print& print) {
  if (!layer.step) return std::nullopt;
  switch (*layer.step) {
    case PrintStep::dielectric:
      return Colour{0.25, 0.65, 0.4, 0.75};
    case PrintStep::bridges:
      return Colour{0.8, 0.35, 0.05, 1};
    case PrintStep::resist:
      return Colour{0.5, 0.3, 0.75, 0.45};
    case PrintStep::picture:
      return std::nullopt;
    case PrintStep::conductor:
      break;
  }
  return layer.face == print.main().face ? Colour{0.1, 0.1, 0.1, 1} : Colour{0.15, 0.35, 0.75, 1};
}

}  // namespace

SheetPicture::SheetPicture(const Finished& job, InkState state, double pixel_mm)
    : job_(job),
      grid_{static_cast<int>(std::ceil(job.settings.sheet.width_mm / pixel_mm)),
            static_cast<int>(std::ceil(job.settings.sheet.height_mm / pixel_mm)), pixel_mm},
      chart_(job.sheet.triangles, job.sheet.rest, job.flattening.triangles) {
  for (const Layer& layer : job.print.layers) {
    const Pattern* const pattern = layer.source->under_charts();
    layers_.push_back({pattern, pattern ? Pixels() : pixels_of(*layer.source->shown(grid_, state)),
                       tint_of(layer, job.print), layer.step || layer.name == "print"});
  }
}

SheetPicture::Pixels SheetPicture::pixels_of(const RowSource& source) const {
  Pixels rgba;
  rgba.reserve(4 * static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height));
  for (int top = 0; top < grid_.height; top += source.band_rows()) {
    const auto band = source.rows(top, std::min(top + source.band_rows(), grid_.height));
    if (source.channels() == 4) {
      rgba.insert(rgba.end(), band.begin(), band.end());
      continue;
    }
    for (const std::uint8_t gray : band)
      rgba.insert(rgba.end(), {0, 0, 0, static_cast<std::uint8_t>(255 - gray)});
  }
  return rgba;
}

Ink SheetPicture::sample(const Eigen::Vector2d& rest, double blur_mm) const {
  return over(of_layer(layers_.front(), rest, blur_mm), 1, true, rest, blur_mm);
}

Ink SheetPicture::over_lower(const Ink& ink, const Eigen::Vector2d& rest, double blur_mm) const {
  return over(ink, 0, false, rest, blur_mm);
}

Ink SheetPicture::over(Ink ink, std::size_t first, bool pattern_too, const Eigen::Vector2d& rest,
                       double blur_mm) const {
  for (std::size_t i = first; i < layers_.size(); ++i) {
    if (layers_[i].of_pattern && !pattern_too) continue;
    const Ink below = of_layer(layers_[i], rest, blur_mm);
    const float through = (1 - ink.a) * below.a, a = ink.a + through;
    const auto mixed = [&](float upper, float lower) { return (ink.a * upper + through * lower) / a; };
    ink = a > 0 ? Ink{mixed(ink.r, below.r), mixed(ink.g, below.g), mixed(ink.b, below.b), a} : Ink();
  }
  return ink;
}

Ink SheetPicture::of_layer(const Shown& layer, const Eigen::Vector2d& rest, double blur_mm) const {
  const Ink ink = layer.pattern ? of_pattern(*layer.pattern, rest, blur_mm) : of_pixels(layer.pixels, rest);
  if (!layer.tint) return ink;
  const auto part = [](double value) { return static_cast<float>(value); };
  return {part(layer.tint->r), part(layer.tint->g), part(layer.tint->b),
          part(layer.tint->a) * ink.coverage()};
}

// Bilinear, with pixels weighted by their opacity.
Ink SheetPicture::of_pixels(const Pixels& rgba, const Eigen::Vector2d& rest) const {
  const int width = grid_.width, height = grid_.height;
  const double x = rest.x() / grid_.pixel_mm + width / 2.0 - 0.5,
               y = height / 2.0 - rest.y() / grid_.pixel_mm - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  if (left >= 0 && top >= 0 && left + 1 < width && top + 1 < height) {  // most of the sheet is bare
    const std::uint8_t* above = &rgba[4 * (static_cast<std::size_t>(top) * static_cast<std::size_t>(width) +
                                           static_cast<std::size_t>(left))];
    const std::uint8_t* below = above + 4 * static_cast<std::ptrdiff_t>(width);
    if ((above[3] | above[7] | below[3] | below[7]) == 0) return {};
  }
  float sum[4] = {0, 0, 0, 0};
  for (int j = top; j < top + 2; ++j)
    for (int i = left; i < left + 2; ++i) {
      if (i < 0 || j < 0 || i >= width || j >= height) continue;
      const std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                                         static_cast<std::size_t>(i))];
      const double weight = (1 - std::abs(x - i)) * (1 - std::abs(y - j));
      const float opacity = static_cast<float>(weight) * part_of_255[p[3]];
      for (int k = 0; k < 3; ++k) sum[k] += opacity * part_of_255[p[k]];
      sum[3] += opacity;
    }
  if (!(sum[3] > 0)) return {};
  return {sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3], std::min(1.0f, sum[3])};
}

Ink SheetPicture::of_pattern(const Pattern& pattern, const Eigen::Vector2d& rest, double blur_mm) const {
  const auto at = chart_.find(rest);
  if (!at) return {};
  const auto& region = job_.flattening.triangles;
  const auto row = std::lower_bound(region.begin(), region.end(), at->triangle) - region.begin();
  const auto& uv = job_.print.pattern_uv[row];
  return pattern.sample(at->weights[0] * uv[0] + at->weights[1] * uv[1] + at->weights[2] * uv[2], blur_mm);
}

}  // namespace vacuform
