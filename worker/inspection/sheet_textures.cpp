#include "worker/inspection/sheet_textures.hpp"

#include <algorithm>
#include <cmath>

#include "worker/inspection/shrunk_png.hpp"
#include "worker/png/png_writer.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

int texture_width(const PrintGrid& print) {
  const std::int64_t longer = std::max(print.width, print.height);
  return std::max(1,
                  static_cast<int>(print.width * std::min<std::int64_t>(longer, largest_texture) / longer));
}

std::uint8_t on_white(float colour, float opacity) {
  return opacity == 0 ? 255 : static_cast<std::uint8_t>(std::lround(255 * (1 + opacity * (colour - 1))));
}

// The pixels of a texture on the flat sheet.
struct TextureGrid {
  int width, height;
  double across, down;  // of a pixel, mm

  explicit TextureGrid(const PrintGrid& print)
      : width(texture_width(print)),
        height(std::max(1, width * print.height / print.width)),
        across(print.width * print.pixel_mm / width),
        down(print.height * print.pixel_mm / height) {}
  Eigen::Vector2d rest(int x, int y) const {
    return {(x + 0.5 - width / 2.0) * across, (height / 2.0 - y - 0.5) * down};
  }
  double pixel_mm() const { return std::max(across, down); }
};

// A picture on white. `ink_of` gives the ink of a row of pixels. Errors: those of `step`, which gets the fraction done.
template <class InkOf, class Step>
Result<std::vector<std::uint8_t>> painted_texture(const TextureGrid& grid, InkOf&& ink_of, Step&& step) {
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(grid.width);
  PngWriter writer(grid.width, grid.height, 3);
  constexpr int band = 64;
  std::vector<std::uint8_t> rows(band * row_bytes);
  for (int top = 0; top < grid.height; top += band) {
    VACUFORM_CHECK(step(static_cast<double>(top) / grid.height));
    const int bottom = std::min(top + band, grid.height);
    in_parallel(top, bottom, [&](int first, int last) {
      std::vector<Ink> line(static_cast<std::size_t>(grid.width));
      for (int y = first; y < last; ++y) {
        ink_of(y, line);
        std::uint8_t* p = &rows[static_cast<std::size_t>(y - top) * row_bytes];
        for (const Ink& ink : line)
          for (const float colour : {ink.r, ink.g, ink.b}) *p++ = on_white(colour, ink.a);
      }
    });
    for (int y = top; y < bottom; ++y) writer.row(&rows[static_cast<std::size_t>(y - top) * row_bytes]);
  }
  return writer.finish();
}

}  // namespace

std::vector<std::uint8_t> print_texture(const Finished& job, const SheetPicture* over) {
  const Layer& top = job.print.main();
  if (!over) return shrunk_png(top.files.png, texture_width(job.print.grid), 0, top.mirrored());
  const TextureGrid grid(job.print.grid);
  const auto print = [&](int y, std::vector<Ink>& line) {
    for (int x = 0; x < grid.width; ++x) line[x] = over->sample(grid.rest(x, y), grid.pixel_mm());
  };
  return *painted_texture(grid, print, [](double) { return Result<void>(); });
}

Result<std::vector<std::uint8_t>> drawing_texture(const Finished& job, const SheetPicture* over,
                                                  const Context& context) {
  const TextureGrid grid(job.print.grid);
  const double blur = grid.pixel_mm() / job.alignment.scale;
  const Eigen::Affine2d to_pattern = job.alignment.to_pattern();
  const Eigen::Vector2d step = to_pattern.linear() * Eigen::Vector2d(grid.across, 0);
  const auto drawing = [&](int y, std::vector<Ink>& line) {
    job.pattern.sample_line(to_pattern * (grid.rest(0, y) - job.flattening.top_rest), step, blur, line);
    if (!over) return;
    for (int x = 0; x < grid.width; ++x) {
      Ink& ink = line[x];
      ink = over->over_lower(ink, grid.rest(x, y), grid.pixel_mm());
    }
  };
  return painted_texture(grid, drawing,
                         [&](double done) { return context.step(Stage::inspection, 0.95 + 0.04 * done); });
}

Eigen::Vector2d texture_place(const Print& print, const Eigen::Vector2d& rest) {
  const Eigen::Vector2d uv = print.picture_uv(rest);
  return {print.main().mirrored() ? 1 - uv.x() : uv.x(), 1 - uv.y()};
}

}  // namespace vacuform
