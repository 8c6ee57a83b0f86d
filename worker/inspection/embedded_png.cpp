#include <algorithm>

#include "worker/inspection/report_html.hpp"
#include "worker/png/png_reader.hpp"
#include "worker/png/png_writer.hpp"

namespace vacuform {

namespace {

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= left ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

struct PixelRows {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};
PixelRows decoded(const std::vector<std::uint8_t>& png) {
  // Width and height stand at fixed places of the first chunk.
  PixelRows out;
  PngReader reader(png);
  if (png.size() < 24 || !reader.begin(PngReader::Rows::rgba8) || reader.passes() != 1) return out;
  const auto number = [&](std::size_t at) {
    return static_cast<int>(png[at] << 24 | png[at + 1] << 16 | png[at + 2] << 8 | png[at + 3]);
  };
  out.width = number(16), out.height = number(20);
  out.rgba.resize(reader.row_bytes() * static_cast<std::size_t>(out.height));
  for (int y = 0; y < out.height; ++y)
    if (!reader.row(out.rgba.data() + reader.row_bytes() * static_cast<std::size_t>(y))) return {};
  return out;
}

// The part of [from, to) that lies in the cell [i, i + 1).
double share(double from, double to, int i) { return std::min(to, i + 1.0) - std::max<double>(from, i); }

}  // namespace

std::string embedded_png(const std::vector<std::uint8_t>& png, int width, int skipped) {
  const PixelRows picture = decoded(png);
  const int shown = picture.height - skipped;
  if (picture.width == 0 || shown <= 0) return {};
  width = std::min(width, picture.width);
  const double scale = static_cast<double>(picture.width) / width;
  const int height = std::max(1, static_cast<int>(shown / scale));
  PngWriter writer(width, height, 3);
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    const double top = skipped + y * scale,
                 bottom = std::min(top + scale, static_cast<double>(picture.height));
    for (int x = 0; x < width; ++x) {
      const double left = x * scale, right = std::min(left + scale, static_cast<double>(picture.width));
      double sum[3] = {0, 0, 0}, area = 0;
      for (int j = static_cast<int>(top); j < bottom; ++j)
        for (int i = static_cast<int>(left); i < right; ++i) {
          const double weight = share(top, bottom, j) * share(left, right, i);
          const std::uint8_t* p =
              &picture.rgba[4 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(picture.width) +
                                 static_cast<std::size_t>(i))];
          for (int k = 0; k < 3; ++k) sum[k] += weight * p[k];
          area += weight;
        }
      for (std::size_t k = 0; k < 3; ++k)
        row[3 * static_cast<std::size_t>(x) + k] = static_cast<std::uint8_t>(sum[k] / area + 0.5);
    }
    writer.row(row.data());
  }
  return base64(writer.finish());
}

}  // namespace vacuform
