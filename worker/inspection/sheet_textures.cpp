#include "worker/inspection/sheet_textures.hpp"

#include <algorithm>
#include <cmath>

#include "worker/inspection/shrunk_png.hpp"
#include "worker/png/png_writer.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

int texture_width(const Print& print) {
  const std::int64_t longer = std::max(print.width, print.height);
  return std::max(1,
                  static_cast<int>(print.width * std::min<std::int64_t>(longer, largest_texture) / longer));
}

std::uint8_t on_white(float colour, float opacity) {
  return opacity == 0 ? 255 : static_cast<std::uint8_t>(std::lround(255 * (1 + opacity * (colour - 1))));
}

}  // namespace

std::vector<std::uint8_t> print_texture(const Finished& job) {
  return shrunk_png(job.print.png, texture_width(job.print), 0, job.print.mirrored);
}

Result<std::vector<std::uint8_t>> drawing_texture(const Finished& job, const Context& context) {
  const Print& print = job.print;
  const int width = texture_width(print), height = std::max(1, width * print.height / print.width);
  const double across = print.width * print.pixel_mm / width, down = print.height * print.pixel_mm / height;
  const double blur = std::max(across, down) / job.alignment.scale;
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(width);
  const Eigen::Affine2d to_pattern = job.alignment.to_pattern();
  PngWriter writer(width, height, 3);
  constexpr int band = 64;
  std::vector<std::uint8_t> rows(band * row_bytes);
  for (int top = 0; top < height; top += band) {
    VACUFORM_CHECK(context.step(Stage::inspection, 0.95 + 0.04 * top / height));
    const int bottom = std::min(top + band, height);
    in_parallel(top, bottom, [&](int first, int last) {
      std::vector<Ink> line(static_cast<std::size_t>(width));
      for (int y = first; y < last; ++y) {
        const Eigen::Vector2d rest((0.5 - width / 2.0) * across, (height / 2.0 - y - 0.5) * down);
        job.pattern.sample_line(to_pattern * (rest - job.flattening.top_rest),
                                to_pattern.linear() * Eigen::Vector2d(across, 0), blur, line);
        std::uint8_t* p = &rows[static_cast<std::size_t>(y - top) * row_bytes];
        for (const Ink& ink : line)
          for (const float colour : {ink.r, ink.g, ink.b}) *p++ = on_white(colour, ink.a);
      }
    });
    for (int y = top; y < bottom; ++y) writer.row(&rows[static_cast<std::size_t>(y - top) * row_bytes]);
  }
  return writer.finish();
}

Eigen::Vector2d texture_place(const Print& print, const Eigen::Vector2d& rest) {
  const Eigen::Vector2d uv = print.picture_uv(rest);
  return {print.mirrored ? 1 - uv.x() : uv.x(), 1 - uv.y()};
}

}  // namespace vacuform
