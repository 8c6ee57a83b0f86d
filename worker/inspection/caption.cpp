#include "worker/inspection/caption.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/inspection/canvas.hpp"

namespace vacuform {
namespace {

constexpr std::array<std::array<float, 3>, 17> viridis_table{{{68, 1, 84},
                                                              {72, 24, 106},
                                                              {71, 45, 123},
                                                              {66, 64, 134},
                                                              {59, 82, 139},
                                                              {51, 99, 141},
                                                              {44, 114, 142},
                                                              {38, 130, 142},
                                                              {33, 145, 140},
                                                              {31, 160, 136},
                                                              {40, 174, 128},
                                                              {63, 188, 115},
                                                              {94, 201, 98},
                                                              {132, 212, 75},
                                                              {173, 220, 48},
                                                              {216, 226, 25},
                                                              {253, 231, 37}}};

}  // namespace

Rgb viridis(double fraction) {
  const double x =
      std::clamp(std::isfinite(fraction) ? fraction : 0.0, 0.0, 1.0) * (viridis_table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(x), viridis_table.size() - 2);
  const float f = static_cast<float>(x - static_cast<double>(i));
  Rgb c;
  for (int k = 0; k < 3; ++k) {
    const auto j = static_cast<std::size_t>(k);
    c[k] = ((1 - f) * viridis_table[i][j] + f * viridis_table[i + 1][j]) / 255;
  }
  return c;
}

Scale round_scale(double low, double high, bool fixed_low, std::string quantity) {
  high = std::max(high, low + 1e-3);
  const double wanted = (high - low) / 6, decade = std::pow(10.0, std::floor(std::log10(wanted)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.5, 2.0, 1.0})
    if (factor * decade >= wanted * (1 - 1e-9)) step = factor * decade;
  const double start = fixed_low ? low : step * std::floor(low / step + 1e-9);
  return {start, start + step * std::max(1.0, std::ceil((high - start) / step - 1e-9)), step,
          std::move(quantity)};
}

void write(const Caption& caption, Picture& picture) {
  Canvas canvas(picture);
  cairo_t* cairo = canvas.cairo();
  canvas.band(0, caption_top, caption_top - 1);
  const double room = picture.width - 80;
  canvas.text(caption.title, 40, 50, 27, true, 0, 0.13f, room);
  canvas.text(caption.figures, 40, 82, 17, false, 0, 0.32f, room);
  canvas.band(picture.height - caption_bottom, picture.height, picture.height - caption_bottom);
  if (!caption.scale) {
    canvas.text(caption.note, 40, picture.height - 40, 17, false, 0, 0.2f, room);
  } else {
    const Scale& s = *caption.scale;
    const double left = 40, right = picture.width - 40.0, top = picture.height - 55.0, thick = 18;
    for (int x = static_cast<int>(left); x < static_cast<int>(right); ++x) {
      const Rgb c = viridis((x + 0.5 - left) / (right - left));
      canvas.colour(c);
      cairo_rectangle(cairo, x, top, 1, thick);
      cairo_fill(cairo);
    }
    canvas.text(s.quantity, left, top - 10, 17, false, 0, 0.2f, room);
    const int steps = static_cast<int>(std::lround((s.high - s.low) / s.step));
    // As many digits as the step needs: two for 0.25, one for 0.2.
    int places = 0;
    for (double step = s.step; places < 6 && std::abs(step - std::round(step)) > 1e-6; step *= 10) ++places;
    for (int i = 0; i <= steps; ++i) {
      const double x = left + (right - left) * i / steps;
      cairo_set_source_rgb(cairo, 0.25, 0.25, 0.27);
      cairo_rectangle(cairo, std::clamp(std::round(x), left, right - 1), top + thick, 1, 6);
      cairo_fill(cairo);
      const std::string value = decimal(s.low + s.step * i, places);
      const bool first = i == 0, last = i == steps;
      canvas.text((last && s.open_above ? "≥ " : "") + value, x, top + thick + 24, 17, false,
                  first  ? 0
                  : last ? 1
                         : 0.5,
                  0.2f);
    }
  }
}

}  // namespace vacuform
