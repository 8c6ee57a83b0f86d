#include "worker/inspection/caption.hpp"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>

#include "worker/printing/decimal.hpp"

namespace vacuform {
namespace {

constexpr std::array<std::array<int, 3>, 17> viridis_table{{{68, 1, 84},    {72, 24, 106},  {71, 45, 123},  {66, 64, 134},
                                                            {59, 82, 139},  {51, 99, 141},  {44, 114, 142}, {38, 130, 142},
                                                            {33, 145, 140}, {31, 160, 136}, {40, 174, 128}, {63, 188, 115},
                                                            {94, 201, 98},  {132, 212, 75}, {173, 220, 48}, {216, 226, 25},
                                                            {253, 231, 37}}};

// A veil over the picture, so that words can be read on anything; solid up to one row and fading
// out towards the other.
void veil(cairo_t* cairo, double top, double bottom, double solid_end, double clear_end) {
  const std::unique_ptr<cairo_pattern_t, void (*)(cairo_pattern_t*)> fade(
      cairo_pattern_create_linear(0, solid_end, 0, clear_end), cairo_pattern_destroy);
  cairo_pattern_add_color_stop_rgba(fade.get(), 0, 0.985, 0.985, 0.99, 0.88);
  cairo_pattern_add_color_stop_rgba(fade.get(), 1, 0.985, 0.985, 0.99, 0);
  cairo_set_source(cairo, fade.get());
  cairo_rectangle(cairo, 0, top, 1e5, bottom - top);
  cairo_fill(cairo);
}

void text(cairo_t* cairo, const std::string& words, double x, double y, double size, bool bold, double along, float gray) {
  cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, words.c_str(), &extents);
  cairo_set_source_rgb(cairo, gray, gray, gray + 0.02);
  cairo_move_to(cairo, x - along * extents.x_advance, y);
  cairo_show_text(cairo, words.c_str());
}

}  // namespace

Colour viridis(double fraction) {
  const double x = std::clamp(std::isfinite(fraction) ? fraction : 0.0, 0.0, 1.0) * (viridis_table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(x), viridis_table.size() - 2);
  const float f = static_cast<float>(x - static_cast<double>(i));
  Colour c;
  for (int k = 0; k < 3; ++k) {
    const auto j = static_cast<std::size_t>(k);
    c[k] = ((1 - f) * static_cast<float>(viridis_table[i][j]) + f * static_cast<float>(viridis_table[i + 1][j])) / 255;
  }
  return c;
}

void write(const Caption& caption, Picture& picture) {
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
      cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(picture.pixels.data()), CAIRO_FORMAT_RGB24,
                                          picture.width, picture.height, 4 * picture.width),
      cairo_surface_destroy);
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  const std::unique_ptr<cairo_t, void (*)(cairo_t*)> context(cairo_create(surface.get()), cairo_destroy);
  cairo_t* cairo = context.get();
  veil(cairo, 0, caption_top + 40, caption_top - 10, caption_top + 40);
  text(cairo, caption.title, 40, 52, 27, true, 0, 0.13f);
  text(cairo, caption.figures, 40, 82, 17, false, 0, 0.32f);
  if (caption.scale) {
    const Scale& s = *caption.scale;
    const double left = 40, right = picture.width - 40.0, top = picture.height - 58.0, thick = 18;
    veil(cairo, top - 70, picture.height, top - 30, top - 70);
    for (int x = static_cast<int>(left); x < static_cast<int>(right); ++x) {
      const Colour c = viridis((x + 0.5 - left) / (right - left));
      cairo_set_source_rgb(cairo, c.x(), c.y(), c.z());
      cairo_rectangle(cairo, x, top, 1, thick);
      cairo_fill(cairo);
    }
    text(cairo, s.quantity, left, top - 9, 17, false, 0, 0.2f);
    constexpr int steps = 5;
    for (int i = 0; i <= steps; ++i) {
      const double x = left + (right - left) * i / steps;
      cairo_set_source_rgb(cairo, 0.25, 0.25, 0.27);
      cairo_rectangle(cairo, std::clamp(std::round(x), left, right - 1), top + thick, 1, 6);
      cairo_fill(cairo);
      const std::string value = decimal(s.low + (s.high - s.low) * i / steps, s.places);
      const bool first = i == 0, last = i == steps;
      const std::string sign = first && s.open_below ? "≤ " : last && s.open_above ? "≥ " : "";
      text(cairo, sign + value, x, top + thick + 25, 17, false, first ? 0 : last ? 1 : 0.5, 0.2f);
    }
  }
  cairo_surface_flush(surface.get());
}

}  // namespace vacuform
