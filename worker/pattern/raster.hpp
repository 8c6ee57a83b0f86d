// The decoders of drawings, and of the textures of scans (worker/colour): bytes in, rows of pixels out.
//
// Decoders trust nothing: sizes are checked before anything is allocated, memory grows with the rows that really
// arrive, and a file that breaks its format's rules is rejected as a whole.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "api/job_limits.hpp"
#include "worker/pattern/svg_work.hpp"

namespace vacuform {

// The most pixels that a drawing may have, or is drawn with.
inline constexpr std::int64_t largest_raster = job_limits.pattern_pixels;

struct Raster {
  int width = 0, height = 0;
  int channels = 1;                  // 1: ink coverage (darkness), 4: premultiplied red, green, blue, alpha
  std::vector<std::uint8_t> pixels;  // rows from the top
  std::optional<Eigen::Vector2d> pixel_mm;       // the file's own resolution
  std::optional<Eigen::Vector2d> exif_pixel_mm;  // another resolution of the same file, in its Exif data
  int orientation = 1;                           // as in Exif: 1 upright ... 8
  bool needs_colour = false;  // channels is 1 and a coloured pixel came: decode again with 4

  // Appends one row of premultiplied RGBA. False when the row has colour that one channel cannot hold.
  bool append(const std::uint8_t* premultiplied);

  // Makes room for a row: at most four times what has come, and in the last step exactly the whole picture.
  void make_room();

  // Turns the picture upright by `orientation`.
  void turn_upright();
};

// What a picture is read for.
struct RasterUse {
  int channels = 4;
  bool texture = false;  // 4 channels: colours as in the file, alpha 0; not turned by Exif
  std::int64_t most_pixels = largest_raster;
  const char* noun() const { return texture ? "texture" : "drawing"; }
};

// Each decodes into a raster of 1 or 4 channels and stops early, with needs_colour set, when 1 is not enough.
// Errors: corrupt_file, too_large, unsupported_format.
Result<Raster> read_png(std::span<const std::uint8_t> bytes, const std::string& file_name,
                        const RasterUse& use);
Result<Raster> read_jpeg(std::span<const std::uint8_t> bytes, const std::string& file_name,
                         const RasterUse& use);
// The error of a picture with too many pixels.
tl::unexpected<Error> too_many_pixels(std::int64_t width, std::int64_t height, const std::string& file_name,
                                      const RasterUse& use);

// Rejects a text that is not SVG or not well-formed XML, that refers to other files (nothing outside the text is ever
// read), or that is too much to draw.
Result<SvgWork> check_svg(const std::string& text, const std::string& file_name);
// Draws the whole document onto width x height pixels.
Result<Raster> draw_svg(const std::string& text, const std::string& file_name, int width, int height,
                        int channels);

}  // namespace vacuform
