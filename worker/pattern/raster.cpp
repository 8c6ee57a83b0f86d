#include "worker/pattern/raster.hpp"

#include <algorithm>
#include <utility>

namespace vacuform {

tl::unexpected<Error> too_many_pixels(std::int64_t width, std::int64_t height, const std::string& file_name,
                                      const RasterUse& use) {
  return fail(Code::too_large,
              std::string("the ") + use.noun() + " has " + std::to_string(width) + " x " +
                  std::to_string(height) + " pixels",
              file_name,
              "give one of at most " + std::to_string(use.most_pixels / 1'000'000) + " million pixels" +
                  (use.texture ? "" : ", or an SVG"));
}

void Raster::make_room() {
  const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
  const std::size_t needed = pixels.size() + row;
  if (needed <= pixels.capacity()) return;
  std::size_t room = row * static_cast<std::size_t>(height);
  while (room / 4 >= needed) room /= 4;
  pixels.reserve(std::max(room, needed));
}

bool Raster::append(const std::uint8_t* row) {
  make_room();
  if (channels == 4) {
    pixels.insert(pixels.end(), row, row + 4 * static_cast<std::ptrdiff_t>(width));
    return true;
  }
  const std::size_t start = pixels.size();
  pixels.resize(start + static_cast<std::size_t>(width), 0);
  for (int x = 0; x < width; ++x, row += 4) {
    if ((row[0] | row[1] | row[2] | row[3]) == 0) continue;  // most of a drawing
    // Rounding in decoders and in premultiplication leaves grays up to two levels apart.
    const int low = std::min(std::min(row[0], row[1]), row[2]),
              high = std::max(std::max(row[0], row[1]), row[2]);
    if (high - low > 2) {
      needs_colour = true;
      return false;
    }
    pixels[start + static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(std::max(0, row[3] - row[1]));
  }
  return true;
}

void Raster::turn_upright() {
  if (orientation <= 1 || orientation > 8) return;
  const bool transposed = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const int new_width = transposed ? height : width, new_height = transposed ? width : height;
  std::vector<std::uint8_t> turned(pixels.size());
  std::uint8_t* out = turned.data();
  for (int y = 0; y < new_height; ++y)
    for (int x = 0; x < new_width; ++x, out += channels) {
      const int across = transposed ? y : x, down = transposed ? x : y;
      const std::int64_t source_x = from_right ? width - 1 - across : across;
      const std::int64_t source_y = from_bottom ? height - 1 - down : down;
      std::copy_n(pixels.data() + (source_y * width + source_x) * channels, channels, out);
    }
  pixels = std::move(turned);
  width = new_width;
  height = new_height;
  for (auto* pixel : {&pixel_mm, &exif_pixel_mm})
    if (transposed && *pixel) std::swap((*pixel)->x(), (*pixel)->y());
  orientation = 1;
}

}  // namespace vacuform
