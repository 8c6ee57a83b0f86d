#include "worker/forming/heat/gray_png.hpp"

#include <algorithm>
#include <array>

#include "worker/png/png_reader.hpp"

namespace vacuform {

namespace {

constexpr std::int64_t most_pixels = 4'000'000;
constexpr int gray = 0, gray_alpha = 4;  // colour types of the PNG header

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() >= signature.size() && std::equal(signature.begin(), signature.end(), bytes.begin());
}

Result<GrayPicture> read_gray_png(std::span<const std::uint8_t> bytes, const std::string& file_name) {
  const auto corrupt = [&](const std::string& what) {
    return fail(Code::corrupt_file, "the PNG is damaged: " + what, file_name, "export the picture again");
  };
  if (bytes.size() < 33 || !is_png(bytes)) return corrupt("the file ends early");
  // From the header itself: libpng's own limits cannot tell a large picture from a damaged one.
  const auto big_endian = [&](std::size_t at) {
    return std::int64_t{bytes[at]} << 24 | std::int64_t{bytes[at + 1]} << 16 |
           std::int64_t{bytes[at + 2]} << 8 | std::int64_t{bytes[at + 3]};
  };
  const std::int64_t width = big_endian(16), height = big_endian(20);
  const int depth = bytes[24], colour_type = bytes[25];
  if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) return corrupt("it has no size");
  if (width > 1'000'000 || height > 1'000'000 || width * height > most_pixels)
    return fail(Code::too_large,
                "the picture has " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                file_name, "give one of at most 4 million pixels");
  if (colour_type != gray && colour_type != gray_alpha)
    return fail(Code::unsupported_format, "the picture of temperatures is in colour, which has no scale",
                file_name, "export it as gray, or the temperatures as CSV");
  const int channels = colour_type == gray ? 1 : 2;
  // Deflate packs at most 1032 to 1; what claims more than that cannot be in the file.
  if ((width * depth * channels + 7) / 8 * height / 1032 > static_cast<std::int64_t>(bytes.size()))
    return corrupt("the file is too short for its size");

  PngReader reader(bytes);
  if (!reader.begin(PngReader::Rows::gray16)) return corrupt(reader.message());
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(width);
  if (reader.row_bytes() != row_bytes) return corrupt("its header contradicts itself");
  std::vector<std::uint8_t> rows(row_bytes * static_cast<std::size_t>(height));
  for (int pass = 0; pass < reader.passes(); ++pass)
    for (std::int64_t y = 0; y < height; ++y)
      if (!reader.row(rows.data() + static_cast<std::size_t>(y) * row_bytes))
        return corrupt(reader.message());
  if (!reader.end()) return corrupt(reader.message());
  GrayPicture picture{static_cast<int>(width), static_cast<int>(height), {}};
  picture.pixels.reserve(rows.size() / 2);
  for (std::size_t i = 0; i < rows.size(); i += 2)
    picture.pixels.push_back(static_cast<std::uint16_t>(rows[i] << 8 | rows[i + 1]));
  return picture;
}

}  // namespace vacuform
