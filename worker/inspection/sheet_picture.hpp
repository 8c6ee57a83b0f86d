// The print as it lies on the flat sheet, to be looked up at sheet coordinates. Internal to worker/inspection.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/inspection/inspection.hpp"
#include "worker/printing/row_source.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// Of a print of vectors, of a picture in parts, or of the colours of the scan, the print itself, 0.15 mm a pixel; of any other the pattern under the
// charts. Keeps a reference to the job.
class SheetPicture {
 public:
  explicit SheetPicture(const Finished& job);

  // Straight colour and opacity at a place of the sheet, before any mirroring, over about `blur_mm`; transparent off it.
  Ink sample(const Eigen::Vector2d& rest, double blur_mm) const;

 private:
  void take(const RowSource& source, int channels);
  Ink of_pixels(const Eigen::Vector2d& rest) const;
  Ink of_pattern(const Eigen::Vector2d& rest, double blur_mm) const;  // of the flat sheet

  const Finished& job_;
  int width_ = 0, height_ = 0;
  std::vector<std::uint8_t> rgba_;  // straight, rows from the top; empty: of the pattern
  PlaneLocator chart_;              // of a pattern: the triangles of the chart
};

}  // namespace vacuform
