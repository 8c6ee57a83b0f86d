#include "worker/inspection/picture_png.hpp"

#include "worker/png/png_writer.hpp"

namespace vacuform {

std::vector<std::uint8_t> png_of(const Picture& picture) {
  PngWriter writer(picture.width, picture.height, 3);
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(picture.width));
  for (int y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(picture.width); ++x) {
      const std::uint32_t p =
          picture.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + x];
      row[3 * x] = static_cast<std::uint8_t>(p >> 16);
      row[3 * x + 1] = static_cast<std::uint8_t>(p >> 8);
      row[3 * x + 2] = static_cast<std::uint8_t>(p);
    }
    writer.row(row.data());
  }
  return writer.finish();
}

}  // namespace vacuform
