#include "worker/printing/vector_raster.hpp"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>

#include "worker/printing/raster_bands.hpp"

namespace vacuform {

namespace {

struct ReleaseCairo {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};

void trace(cairo_t* cairo, const Curve& curve) {
  const auto& p = curve.points;
  cairo_move_to(cairo, p[0].x(), p[0].y());
  for (std::size_t i = 1; i + 2 < p.size(); i += 3)
    cairo_curve_to(cairo, p[i].x(), p[i].y(), p[i + 1].x(), p[i + 1].y(), p[i + 2].x(), p[i + 2].y());
  cairo_close_path(cairo);
}

// From cairo's premultiplied pixel to straight RGBA.
void straight(const unsigned char* in, std::uint8_t* out) {
  std::uint32_t pixel;
  std::memcpy(&pixel, in, 4);
  const unsigned alpha = pixel >> 24;
  if (alpha == 0) return;
  const auto channel = [&](unsigned value) {
    return static_cast<std::uint8_t>(std::min(255u, ((value & 255u) * 255u + alpha / 2) / alpha));
  };
  out[0] = channel(pixel >> 16);
  out[1] = channel(pixel >> 8);
  out[2] = channel(pixel);
  out[3] = static_cast<std::uint8_t>(alpha);
}

}  // namespace

VectorRaster::VectorRaster(const VectorPrint& print, const PrintGrid& grid, bool grayscale)
    : width_(grid.width),
      height_(grid.height),
      band_(band_rows_of(grid.width)),
      pixel_mm_(grid.pixel_mm),
      grayscale_(grayscale) {
  for (const PrintedElement& element : print.elements)
    for (const PaintedArea& area : element.areas) {
      Eigen::AlignedBox2d box;
      std::vector<std::pair<double, double>> ranges;
      for (const Curve& curve : area.outlines) {
        Eigen::AlignedBox2d around;
        for (const Eigen::Vector2d& p : curve.points) around.extend(p);
        ranges.emplace_back(around.min().y(), around.max().y());
        box.extend(around);
      }
      if (box.isEmpty()) continue;
      areas_.push_back({&area, box.min().y(), box.max().y(), std::move(ranges)});
      box_.extend(box);
    }
}

PixelBox VectorRaster::box() const {
  if (box_.isEmpty()) return {0, 0, 1, 1};
  const auto pixel = [](double x, int limit) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(limit)));
  };
  PixelBox out;
  out.left = pixel(std::floor(box_.min().x() / pixel_mm_ + 0.5 * width_), width_ - 1);
  out.top = pixel(std::floor(0.5 * height_ - box_.max().y() / pixel_mm_), height_ - 1);
  out.right = std::max(out.left + 1, pixel(std::ceil(box_.max().x() / pixel_mm_ + 0.5 * width_), width_));
  out.bottom = std::max(out.top + 1, pixel(std::ceil(0.5 * height_ - box_.min().y() / pixel_mm_), height_));
  return out;
}

std::vector<std::uint8_t> VectorRaster::rows(int top, int bottom) const {
  const int count = bottom - top;
  const std::size_t each = grayscale_ ? 1 : 4;
  std::vector<std::uint8_t> out(static_cast<std::size_t>(width_) * static_cast<std::size_t>(count) * each,
                                grayscale_ ? std::uint8_t{255} : std::uint8_t{0});
  const double high = (0.5 * height_ - top + 1) * pixel_mm_, low = (0.5 * height_ - bottom - 1) * pixel_mm_;
  const auto touches = [&](const Painted& p) { return p.low <= high && p.high >= low; };
  if (std::none_of(areas_.begin(), areas_.end(), touches)) return out;

  const std::unique_ptr<cairo_surface_t, ReleaseCairo> surface(
      cairo_image_surface_create(grayscale_ ? CAIRO_FORMAT_RGB24 : CAIRO_FORMAT_ARGB32, width_, count));
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  {
    const std::unique_ptr<cairo_t, ReleaseCairo> held(cairo_create(surface.get()));
    cairo_t* cairo = held.get();
    if (grayscale_) {
      cairo_set_source_rgb(cairo, 1, 1, 1);
      cairo_paint(cairo);
    }
    cairo_translate(cairo, 0.5 * width_, 0.5 * height_ - top);
    cairo_scale(cairo, 1 / pixel_mm_, -1 / pixel_mm_);
    for (const Painted& painted : areas_) {
      if (!touches(painted)) continue;
      const PaintedArea& area = *painted.area;
      cairo_new_path(cairo);
      for (std::size_t i = 0; i < area.outlines.size(); ++i)
        if (painted.ranges[i].first <= high && painted.ranges[i].second >= low)
          trace(cairo, area.outlines[i]);
      cairo_set_fill_rule(cairo, area.even_odd ? CAIRO_FILL_RULE_EVEN_ODD : CAIRO_FILL_RULE_WINDING);
      cairo_set_source_rgba(cairo, area.colour.r, area.colour.g, area.colour.b, area.colour.a);
      cairo_fill(cairo);
    }
  }
  cairo_surface_flush(surface.get());
  const unsigned char* data = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  std::uint8_t* pixel = out.data();
  for (int y = 0; y < count; ++y) {
    const unsigned char* row = data + static_cast<std::ptrdiff_t>(y) * stride;
    for (int x = 0; x < width_; ++x, row += 4, pixel += each) {
      if (grayscale_)
        pixel[0] = row[1];
      else
        straight(row, pixel);
    }
  }
  return out;
}

}  // namespace vacuform
