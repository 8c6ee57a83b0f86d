// The chart's triangles, filled with the drawing, in rows of print pixels. Internal to worker/printing.
#pragma once

#include <array>
#include <vector>

#include "worker/printing/print.hpp"

namespace vacuform {

struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;  // half open
};

// Keeps references to what it is made of. Pixels are those of the print before any mirroring.
class SheetRaster {
 public:
  // Of `print`, the size, the pixel and pattern_uv are read.
  SheetRaster(const FormedSheet& sheet, const Flattening& flattening, const Print& print,
              const Pattern& pattern, int dpi);

  PixelBox box() const { return box_; }    // around the chart, never empty
  int band_rows() const { return band_; }  // rows to ask for at once

  // Rows [top, bottom), where top is a multiple of band_rows() and bottom at most one band further: 8-bit
  // gray on white for a grayscale drawing, else straight RGBA on transparent.
  std::vector<std::uint8_t> rows(int top, int bottom) const;

 private:
  // One triangle: its corners on the grid of samples, and the affine map from there to pattern coordinates.
  struct Patch {
    std::array<Eigen::Vector2d, 3> corners;
    Eigen::Vector2d origin, across, down;  // uv = origin + x across + y down
    double blur;
  };
  void scan(const Patch& patch, int first_row, int last_row, int top, std::vector<float>& sums) const;

  const Pattern& pattern_;
  int width_, height_, channels_, samples_, band_;
  PixelBox box_;
  std::vector<Patch> patches_;
  std::vector<std::vector<int>> of_band_;  // patches that may touch each band, ascending
};

}  // namespace vacuform
