// The images of a scan, to be sampled in linear light.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "api/base/error.hpp"
#include "worker/scan/scan_colours.hpp"

namespace vacuform {

// Limits for one image, and for all images of a scan together.
inline constexpr std::int64_t largest_texture_side = 16'384;
inline constexpr std::int64_t most_texture_pixels = largest_texture_side * largest_texture_side;

// The part of a texture that is averaged around a place: `probes` samples in a row, each over a square of `side`
// texels.
struct Footprint {
  Eigen::Vector2d step{0, 0};  // from one sample to the next, in sides of the image
  int probes = 1;
  double level = 0;  // of the pyramid: 0 is the image, each next one half as wide
};

// A pyramid of box-filtered images (L. Williams 1983, "Pyramidal parametrics"), averaged in linear light. Texels that
// no triangle shows have no weight, so that the space between the islands of an unwrapped surface never bleeds into
// them.
class Texture {
 public:
  using Corners = std::array<Eigen::Vector2f, 3>;

  // Unpacks a PNG or JPEG. The first bytes determine the format. Errors: unsupported_format (names KTX2 and WebP),
  // corrupt_file, too_large (more than `most_pixels`, or 16,384 pixels on a side). `where` is the scan's name.
  static Result<Texture> read(const ScanImage& image, const std::string& where, std::int64_t most_pixels);

  std::int64_t pixels() const { return std::int64_t{levels_[0].width} * levels_[0].height; }

  // Marks the texels whose centres lie in one of the triangles, which show the image with this wrapping. A triangle
  // that holds no centre marks the texels below its corners and its middle. Call it once for each material, then
  // build().
  void mark_shown(std::span<const Corners> triangles, Wrap across, Wrap down);
  // Makes the smaller levels. If nothing was marked, everything counts as marked.
  void build();

  // The footprint of a parallelogram whose sides, in sides of the image, are a and b.
  Footprint footprint(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;
  // Red, green and blue in linear light around `uv` (from the left and the top). If nothing near is marked, all texels
  // count. Thread safe and deterministic.
  Eigen::Vector3f sample(const Eigen::Vector2d& uv, const Footprint& footprint, Wrap across, Wrap down) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  // sRGB, and the share of the texel that is shown

    const std::uint8_t* row(int y) const {
      return rgba.data() + 4 * static_cast<std::ptrdiff_t>(width) * static_cast<std::ptrdiff_t>(y);
    }
    std::uint8_t* row(int y) { return const_cast<std::uint8_t*>(std::as_const(*this).row(y)); }
  };
  static Level halve(const Level& fine);
  // Gives the texels beside the shown ones the colours that continue those, so that interpolation reaches the border of
  // an island. Where two islands with different colours are that near, the texel stays as it is.
  static void continue_islands(Level& level);
  // Bilinear: the sum of the colours by their shares, and of the shares.
  static Eigen::Vector4f mean(const Level& level, double x, double y, Wrap across, Wrap down, bool all);

  std::vector<Level> levels_;
  bool marked_ = false, all_shown_ = false;
};

}  // namespace vacuform
