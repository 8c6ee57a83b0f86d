#include "worker/inspection/caption.hpp"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

#include "worker/decimal.hpp"

namespace vacuform {
namespace {

constexpr std::array<std::array<int, 3>, 17> viridis_table{{{68, 1, 84},
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

// Paper for words to stand on.
void band(cairo_t* cairo, double top, double bottom, double line) {
  cairo_set_source_rgb(cairo, 0.985, 0.985, 0.99);
  cairo_rectangle(cairo, 0, top, 1e5, bottom - top);
  cairo_fill(cairo);
  cairo_set_source_rgb(cairo, 0.78, 0.79, 0.81);
  cairo_rectangle(cairo, 0, line, 1e5, 1);
  cairo_fill(cairo);
}

void text(cairo_t* cairo, const std::string& words, double x, double y, double size, bool bold, double along,
          float gray) {
  cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, words.c_str(), &extents);
  cairo_set_source_rgb(cairo, gray, gray, gray + 0.02);
  cairo_move_to(cairo, x - along * extents.x_advance, y);
  cairo_show_text(cairo, words.c_str());
}

}  // namespace

Colour viridis(double fraction) {
  const double x =
      std::clamp(std::isfinite(fraction) ? fraction : 0.0, 0.0, 1.0) * (viridis_table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(x), viridis_table.size() - 2);
  const float f = static_cast<float>(x - static_cast<double>(i));
  Colour c;
  for (int k = 0; k < 3; ++k) {
    const auto j = static_cast<std::size_t>(k);
    c[k] = ((1 - f) * static_cast<float>(viridis_table[i][j]) +
            f * static_cast<float>(viridis_table[i + 1][j])) /
           255;
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
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
      cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(picture.pixels.data()),
                                          CAIRO_FORMAT_RGB24, picture.width, picture.height,
                                          4 * picture.width),
      cairo_surface_destroy);
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  const std::unique_ptr<cairo_t, void (*)(cairo_t*)> context(cairo_create(surface.get()), cairo_destroy);
  cairo_t* cairo = context.get();
  band(cairo, 0, caption_top, caption_top - 1);
  text(cairo, caption.title, 40, 50, 27, true, 0, 0.13f);
  text(cairo, caption.figures, 40, 82, 17, false, 0, 0.32f);
  band(cairo, picture.height - caption_bottom, picture.height, picture.height - caption_bottom);
  if (!caption.scale) {
    text(cairo, caption.note, 40, picture.height - 40, 17, false, 0, 0.2f);
  } else {
    const Scale& s = *caption.scale;
    const double left = 40, right = picture.width - 40.0, top = picture.height - 55.0, thick = 18;
    for (int x = static_cast<int>(left); x < static_cast<int>(right); ++x) {
      const Colour c = viridis((x + 0.5 - left) / (right - left));
      cairo_set_source_rgb(cairo, c.x(), c.y(), c.z());
      cairo_rectangle(cairo, x, top, 1, thick);
      cairo_fill(cairo);
    }
    text(cairo, s.quantity, left, top - 10, 17, false, 0, 0.2f);
    const int steps = static_cast<int>(std::lround((s.high - s.low) / s.step));
    // As many digits as the step needs: 0.25 two, 0.2 one.
    int places = 0;
    for (double step = s.step; places < 6 && std::abs(step - std::round(step)) > 1e-6; step *= 10) ++places;
    for (int i = 0; i <= steps; ++i) {
      const double x = left + (right - left) * i / steps;
      cairo_set_source_rgb(cairo, 0.25, 0.25, 0.27);
      cairo_rectangle(cairo, std::clamp(std::round(x), left, right - 1), top + thick, 1, 6);
      cairo_fill(cairo);
      const std::string value = decimal(s.low + s.step * i, places);
      const bool first = i == 0, last = i == steps;
      text(cairo, (last && s.open_above ? "≥ " : "") + value, x, top + thick + 24, 17, false,
           first  ? 0
           : last ? 1
                  : 0.5,
           0.2f);
    }
  }
  cairo_surface_flush(surface.get());
}

}  // namespace vacuform
