// The chart's triangles, filled with the drawing, in rows of print pixels. Internal to worker/printing.
#pragma once

#include <array>
#include <vector>

#include "worker/printing/print.hpp"
#include "worker/printing/row_source.hpp"

namespace vacuform {

// Keeps references to what it is made of. Pixels are those of the print before any mirroring; the box is the chart's.
class SheetRaster : public RowSource {
 public:
  // Of `print`, the size and the pixel are read. `gain` multiplies the ink of each of the chart's triangles, up to full
  // coverage; empty for none. Of a grayscale drawing only.
  SheetRaster(const Patch& chart, const std::vector<double>& gain, const Print& print, const Pattern& pattern,
              int dpi);

  PixelBox box() const override { return box_; }
  int band_rows() const override { return band_; }
  std::vector<std::uint8_t> rows(int top, int bottom) const override;

 private:
  // One triangle: its corners on the grid of samples, and the affine map from there to pattern coordinates.
  struct Piece {
    std::array<Eigen::Vector2d, 3> corners;
    Eigen::Vector2d origin, across, down;  // uv = origin + x across + y down
    double blur;
    float gain;
  };
  void scan(const Piece& piece, int first_row, int last_row, int top, std::vector<float>& sums) const;

  const Pattern& pattern_;
  int width_, height_, channels_, samples_, band_;
  PixelBox box_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<int>> of_band_;  // pieces that may touch each band, ascending
};

}  // namespace vacuform
