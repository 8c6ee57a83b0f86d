#include "worker/inspection/canvas.hpp"

#include <algorithm>
#include <new>

namespace vacuform {

Canvas::Canvas(Picture& picture)
    : width_(picture.width),
      surface_(cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(picture.pixels.data()),
                                                   CAIRO_FORMAT_RGB24, picture.width, picture.height,
                                                   4 * picture.width),
               cairo_surface_destroy),
      context_(cairo_create(surface_.get()), cairo_destroy) {
  if (cairo_surface_status(surface_.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
}

Canvas::~Canvas() { cairo_surface_flush(surface_.get()); }

void Canvas::band(double top, double bottom, double line) {
  cairo_set_source_rgb(cairo(), 0.985, 0.985, 0.99);
  cairo_rectangle(cairo(), 0, top, 1e5, bottom - top);
  cairo_fill(cairo());
  cairo_set_source_rgb(cairo(), 0.78, 0.79, 0.81);
  cairo_rectangle(cairo(), 0, line, 1e5, 1);
  cairo_fill(cairo());
}

double Canvas::text(const std::string& words, double x, double y, double size, bool bold, double along,
                    const Rgb& colour_of_words, double room) {
  constexpr double margin = 6;
  cairo_select_font_face(cairo(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo(), size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo(), words.c_str(), &extents);
  if (along > 0) room = std::min(room, (x - margin) / along);
  if (along < 1) room = std::min(room, (width_ - margin - x) / (1 - along));
  while (extents.x_advance > room && room > 0) {  // widths are rounded at each size
    size *= 0.99 * room / extents.x_advance;
    cairo_set_font_size(cairo(), size);
    cairo_text_extents(cairo(), words.c_str(), &extents);
  }
  colour(colour_of_words);
  cairo_move_to(cairo(), x - along * extents.x_advance, y);
  cairo_show_text(cairo(), words.c_str());
  return size;
}

}  // namespace vacuform
