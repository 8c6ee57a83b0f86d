// Words and shapes on a picture, by cairo. Internal to the .cpp files of worker/inspection that draw.
#pragma once

#include <cairo.h>

#include <memory>
#include <string>

#include "worker/inspection/view.hpp"

namespace vacuform {

// Draws straight into the picture, which outlives it and keeps its size; done when it is destroyed.
class Canvas {
 public:
  explicit Canvas(Picture& picture);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  cairo_t* cairo() { return context_.get(); }
  void colour(const Rgb& c) { cairo_set_source_rgb(cairo(), c.x(), c.y(), c.z()); }

  // Paper for words to stand on, from row `top` to row `bottom`, with a line at its edge.
  void band(double top, double bottom, double line);
  // The words' base line at y; `along` of their width (0: none, 1: all) lies to the left of x.
  void text(const std::string& words, double x, double y, double size, bool bold, double along,
            const Rgb& colour);
  void text(const std::string& words, double x, double y, double size, bool bold, double along, float gray) {
    text(words, x, y, size, bold, along, Rgb(gray, gray, gray + 0.02f));
  }

 private:
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> context_;
};

}  // namespace vacuform
