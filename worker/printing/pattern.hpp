// The user's drawing: PNG, JPEG or SVG bytes in, a picture that can be sampled at physical positions out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "api/settings.hpp"
#include "worker/context.hpp"

namespace vacuform {

// One filtered sample: straight (not premultiplied) colour and opacity, each in [0, 1]. Off the drawing: transparent.
struct Ink {
  float r = 0, g = 0, b = 0, a = 0;
};

class Pattern {
 public:
  // Decodes the drawing; an SVG is drawn finely enough for prints at `dpi`. Its physical size is, in this order:
  // settings.width_mm; the SVG's width in absolute units; the PNG's pHYs or the JPEG's density; else unusable_pattern
  // with the mend "give pattern.width_mm". Errors: unsupported_format, corrupt_file, too_large, unusable_pattern.
  static Result<Pattern> read(std::span<const std::uint8_t> bytes, const std::string& file_name,
                              const PatternSettings& settings, int dpi);
  ~Pattern();
  Pattern(Pattern&&) noexcept;
  Pattern& operator=(Pattern&&) noexcept;

  Eigen::Vector2d size_mm() const;  // of the whole drawing
  bool grayscale() const;           // no colour and no transparency: the print is grayscale too
  const std::string& format() const;  // "SVG", "PNG", "JPEG"

  // The drawing around `uv` (mm from its centre, v up), averaged over a disk-like footprint of diameter `blur_mm`
  // (box-filtered pyramid, bilinear between and within levels). Thread safe and deterministic.
  Ink sample(const Eigen::Vector2d& uv, double blur_mm) const;

 private:
  struct Picture;
  explicit Pattern(std::shared_ptr<const Picture>);
  std::shared_ptr<const Picture> picture_;
};

}  // namespace vacuform
