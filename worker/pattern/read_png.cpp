#include <algorithm>

#include "worker/pattern/raster.hpp"
#include "worker/png/png_reader.hpp"

namespace vacuform {
namespace {

void without_alpha(std::vector<std::uint8_t>& row) {
  for (std::size_t i = 3; i < row.size(); i += 4) row[i] = 0;
}

void premultiply(std::vector<std::uint8_t>& row) {
  for (std::size_t i = 0; i < row.size(); i += 4) {
    const int a = row[i + 3];
    if (a != 255)
      for (std::size_t k = i; k < i + 3; ++k) row[k] = static_cast<std::uint8_t>((row[k] * a + 127) / 255);
  }
}

std::uint32_t big_endian(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}

}  // namespace

Result<Raster> read_png(std::span<const std::uint8_t> bytes, const std::string& file_name,
                        const RasterUse& use) {
  const auto corrupt = [&](const std::string& what) {
    return fail(Code::corrupt_file, "the PNG is damaged: " + what, file_name,
                std::string("export the ") + use.noun() + " again");
  };
  if (bytes.size() < 33) return corrupt("the file ends early");
  // Sizes first, from the header itself: libpng's own limits cannot tell a large picture from a damaged one.
  const std::int64_t width = big_endian(&bytes[16]), height = big_endian(&bytes[20]);
  if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) return corrupt("it has no size");
  if (width > 1'000'000 || height > 1'000'000 || width * height > use.most_pixels)
    return too_many_pixels(width, height, file_name, use);

  PngReader reader(bytes);
  if (!reader.begin(PngReader::Rows::rgba8)) return corrupt(reader.message());
  // Deflate packs at most 1032 to 1; what claims more than that cannot be in the file.
  const std::int64_t packed_at_least = (width * reader.bits_per_pixel() + 7) / 8 * height / 1032;
  if (packed_at_least > static_cast<std::int64_t>(bytes.size()))
    return corrupt("the file is too short for its size");
  if (reader.passes() > 1 && width * height > use.most_pixels / 4)
    return fail(Code::too_large,
                std::string("the ") + use.noun() + " is an interlaced PNG of more than " +
                    std::to_string(use.most_pixels / 4'000'000) + " million pixels",
                file_name, "save it without interlacing");

  const auto pixel = reader.pixel_size();
  Raster raster{
      .width = static_cast<int>(width),
      .height = static_cast<int>(height),
      .channels = use.channels,
      .pixels = {},
      .pixel_mm = pixel ? std::optional(Eigen::Vector2d(pixel->width_mm, pixel->height_mm)) : std::nullopt,
      .exif_pixel_mm = {},
      .orientation = 1,
      .needs_colour = false};
  const std::size_t row_bytes = 4 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> row(row_bytes);
  if (reader.passes() == 1) {
    for (std::int64_t y = 0; y < height; ++y) {
      if (!reader.row(row.data())) return corrupt(reader.message());
      use.texture ? without_alpha(row) : premultiply(row);
      if (!raster.append(row.data())) return raster;
    }
  } else {
    std::vector<std::uint8_t> image(row_bytes * static_cast<std::size_t>(height));
    for (int pass = 0; pass < reader.passes(); ++pass)
      for (std::int64_t y = 0; y < height; ++y)
        if (!reader.row(image.data() + static_cast<std::size_t>(y) * row_bytes))
          return corrupt(reader.message());
    for (std::int64_t y = 0; y < height; ++y) {
      std::copy_n(image.data() + static_cast<std::size_t>(y) * row_bytes, row_bytes, row.data());
      use.texture ? without_alpha(row) : premultiply(row);
      if (!raster.append(row.data())) return raster;
    }
  }
  if (!reader.end()) return corrupt(reader.message());
  return raster;
}

}  // namespace vacuform
