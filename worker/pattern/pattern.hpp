// The drawing of the user: reads PNG, JPEG or SVG bytes and makes a picture that can be sampled at physical positions.
//
// *Ink* is what is not white: coverage = alpha * (1 - luminance), with the Rec. 709 luminance of the colour
// as encoded. A white background, opaque or not, carries no ink.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// One filtered sample: straight (not premultiplied) colour and opacity, each in [0, 1]. Off the drawing:
// transparent.
struct Ink {
  float r = 0, g = 0, b = 0, a = 0;
  float coverage() const { return a * (1 - (0.2126f * r + 0.7152f * g + 0.0722f * b)); }
};

class Pattern {
 public:
  // Decodes the drawing. An SVG is drawn finely enough for prints at `dpi`, but with at most 64 million pixels, and
  // fewer if more would take longer than about ten seconds of processor time (svg_work.hpp). The first bytes determine
  // the format, not the name. The physical size is, in this order: settings.width_mm; the width or height of the SVG in
  // mm, cm, in, pt or pc; settings.dpi pixels an inch; the pixels of the program that wrote the SVG, where it is known;
  // the pHYs of the PNG or the density of the JPEG, in JFIF or Exif. For pictures settings.dpi counts before the file.
  // Otherwise, and where these contradict each other, unusable_pattern, with the settings that choose a size as
  // proposals. The Exif orientation of a JPEG is applied. Only the bytes are read: an SVG that refers to other files is
  // rejected. Errors: unsupported_format (which format it is, where that is known), corrupt_file, too_large (above 64
  // million pixels, or too much work to draw), unusable_pattern (no ink or size).
  static Result<Pattern> read(std::span<const std::uint8_t> bytes, const std::string& file_name,
                              const PatternSettings& settings, int dpi);
  // A picture that was made, not read: rows from the top of premultiplied red, green, blue and alpha. It may be without
  // ink.
  static Pattern of_picture(const Eigen::Vector2i& size_pixels, std::vector<std::uint8_t> premultiplied,
                            const Eigen::Vector2d& size_mm, std::string format);
  ~Pattern();
  Pattern(Pattern&&) noexcept;
  Pattern& operator=(Pattern&&) noexcept;

  Eigen::Vector2d size_mm() const;      // of the whole drawing
  Eigen::Vector2i size_pixels() const;  // as decoded or drawn
  bool grayscale() const;             // no colour anywhere: the print is grayscale too, transparency is white
  const std::string& format() const;  // "SVG", "PNG", "JPEG"
  const std::string& size_from()
      const;  // which unit and why, such as "120 x 80 mm, as the file says"; empty if made
  // The text that was drawn: UTF-8, its size in mm (svg_size.hpp). Empty if the drawing is no SVG.
  const std::string& svg() const;
  double ink_mm2() const;  // area of the drawing's ink, each pixel by its coverage; above 0
  const std::vector<Warning>& warnings() const;  // "pattern-coarse", "pattern-units"

  // The drawing around `uv` (mm from its centre, v up), averaged over a disk-like footprint of diameter `blur_mm`
  // (box-filtered pyramid, bilinear between and within levels). A grayscale drawing gives black at the opacity of its
  // ink coverage. Thread safe and deterministic.
  Ink sample(const Eigen::Vector2d& uv, double blur_mm) const;

  // The same at `count` points start + k step, k = 0, 1, ..., for the inner loops. A grayscale drawing gives one float
  // per point, the coverage; any other gives four, premultiplied red, green, blue and alpha.
  void sample_line(const Eigen::Vector2d& start, const Eigen::Vector2d& step, int count, double blur_mm,
                   float* out) const;
  // The same, in the form that sample() returns.
  void sample_line(const Eigen::Vector2d& start, const Eigen::Vector2d& step, double blur_mm,
                   std::span<Ink> out) const;

 private:
  struct Picture;
  explicit Pattern(std::shared_ptr<const Picture>);
  std::shared_ptr<const Picture> picture_;
};

}  // namespace vacuform
