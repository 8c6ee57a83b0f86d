// Text and shapes on a picture, by cairo. Internal to the .cpp files of worker/inspection that draw.
#pragma once

#include <cairo.h>

#include <cmath>
#include <memory>
#include <string>

#include "worker/inspection/view.hpp"

namespace vacuform {

// Draws straight into the picture, which must outlive it and keep its size. The drawing is complete when it is
// destroyed.
class Canvas {
 public:
  explicit Canvas(Picture& picture);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  cairo_t* cairo() { return context_.get(); }
  void colour(const Rgb& c) { cairo_set_source_rgb(cairo(), c.x(), c.y(), c.z()); }

  // A background for text from row `top` to row `bottom`, with a line at its edge.
  void band(double top, double bottom, double line);
  // The base line of the text is at y; the fraction `along` of its width (0: none, 1: all) lies to the left of x. A text
  // that would reach over the edge of the picture, or is wider than `room`, is written smaller. Returns its size.
  double text(const std::string& words, double x, double y, double size, bool bold, double along,
              const Rgb& colour, double room = HUGE_VAL);
  double text(const std::string& words, double x, double y, double size, bool bold, double along, float gray,
              double room = HUGE_VAL) {
    return text(words, x, y, size, bold, along, Rgb(gray, gray, gray + 0.02f), room);
  }

 private:
  double width_;
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> context_;
};

}  // namespace vacuform
