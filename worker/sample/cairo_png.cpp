#include "worker/sample/cairo_png.hpp"

#include <cstring>

#include "worker/png/png_writer.hpp"

namespace vacuform {

std::vector<std::uint8_t> png_of(cairo_surface_t* surface) {
  cairo_surface_flush(surface);
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(surface));
  const int width = cairo_image_surface_get_width(surface), height = cairo_image_surface_get_height(surface);
  const unsigned char* rows = cairo_image_surface_get_data(surface);
  PngWriter writer(width, height, 3);
  std::vector<std::uint8_t> out(3 * static_cast<std::size_t>(width));
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, rows + y * stride + 4 * x, 4);
      for (std::size_t k = 0; k < 3; ++k) out[3 * x + k] = static_cast<std::uint8_t>(pixel >> (16 - 8 * k));
    }
    writer.row(out.data());
  }
  return writer.finish();
}

}  // namespace vacuform
