// The print as it lies on the flat sheet, to be looked up at sheet coordinates. Internal to worker/inspection.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/colour/ink_curve.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/printing/row_source.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// The layers of the print over each other. Each is drawn once in pixels of `pixel_mm`, except a pattern under the charts,
// which is sampled. Ink that is compensated is in the given state. Keeps a reference to the job.
class SheetPicture {
 public:
  explicit SheetPicture(const Finished& job, InkState state = InkState::stretched, double pixel_mm = 0.15);

  // Straight colour and opacity at a place of the sheet, before any mirroring, over about `blur_mm`; transparent off
  // it.
  Ink sample(const Eigen::Vector2d& rest, double blur_mm) const;
  // The same with other ink in place of what the pattern is.
  Ink over_lower(const Ink& ink, const Eigen::Vector2d& rest, double blur_mm) const;

 private:
  using Pixels = std::vector<std::uint8_t>;  // straight RGBA, rows from the top
  struct Shown {
    const Pattern* pattern;  // under the charts; null: it is drawn
    Pixels pixels;
    std::optional<Colour> tint;  // instead of its own colour
    bool of_pattern;
  };
  Pixels pixels_of(const RowSource& source) const;
  // `ink` and below it the layers from `first` on.
  Ink over(Ink ink, std::size_t first, bool pattern_too, const Eigen::Vector2d& rest, double blur_mm) const;
  Ink of_layer(const Shown& layer, const Eigen::Vector2d& rest, double blur_mm) const;
  Ink of_pixels(const Pixels& rgba, const Eigen::Vector2d& rest) const;
  Ink of_pattern(const Pattern& pattern, const Eigen::Vector2d& rest, double blur_mm) const;

  const Finished& job_;
  const PrintGrid grid_;
  std::vector<Shown> layers_;
  PlaneLocator chart_;  // of a pattern: the triangles of the chart
};

}  // namespace vacuform
