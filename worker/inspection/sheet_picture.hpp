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

// The print itself, in pixels of `pixel_mm`, for a vector print, for a picture in parts, and for the colours of the scan;
// otherwise the pattern under the charts. A drawing over the colours of the scan is shown over them. Colours whose ink is
// compensated are in the given state. Keeps a reference to the job.
class SheetPicture {
 public:
  explicit SheetPicture(const Finished& job, InkState state = InkState::stretched, double pixel_mm = 0.15);

  // Straight colour and opacity at a place of the sheet, before any mirroring, over about `blur_mm`; transparent off
  // it.
  Ink sample(const Eigen::Vector2d& rest, double blur_mm) const;
  // Ink of the drawing at a place of the sheet, over the colours of the scan there if the job prints both.
  Ink over_colours(const Ink& ink, const Eigen::Vector2d& rest) const;

 private:
  using Pixels = std::vector<std::uint8_t>;  // straight RGBA, rows from the top
  Pixels pixels_of(const RowSource& source, int channels) const;
  Ink of_pixels(const Pixels& rgba, const Eigen::Vector2d& rest) const;
  Ink of_pattern(const Eigen::Vector2d& rest, double blur_mm) const;  // of the flat sheet

  const Finished& job_;
  double pixel_mm_;
  int width_ = 0, height_ = 0;
  Pixels print_;        // empty: sampled from the pattern
  Pixels colours_;      // below the drawing; empty without
  PlaneLocator chart_;  // of a pattern: the triangles of the chart
};

}  // namespace vacuform
