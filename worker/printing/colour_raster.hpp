// The colours of a scan on the flat sheet, in rows of print pixels. Internal to worker/printing and worker/inspection.
#pragma once

#include <array>
#include <vector>

#include "worker/colour/sheet_colours.hpp"
#include "worker/printing/row_source.hpp"

namespace vacuform {

// Keeps a reference to the colours. Pixels are those of the print before any mirroring, RGBA: each is the mean, in
// linear light, of some places of the sheet, each with the mean colour of the scan's surface around its closest point.
// The same bytes for any number of threads.
class ColourRaster : public RowSource {
 public:
  // `samples`: places along each side of a pixel. Each has the mean colour of its part of the pixel, so more of them
  // only make borders smoother: 2 for a print, 1 for a picture that is shown smaller.
  ColourRaster(const SheetColours& colours, int width, int height, double pixel_mm, int samples = 2);

  PixelBox box() const override { return box_; }
  int band_rows() const override { return band_; }
  std::vector<std::uint8_t> rows(int top, int bottom) const override;

 private:
  // One triangle: its corners on the grid of samples, the affine map from there to the formed sheet, and a triangle of
  // the scan near its first corner, or -1.
  struct Piece {
    std::array<Eigen::Vector2d, 3> corners;
    Eigen::Vector3d origin, across, down;
    int start = -1;
  };
  void scan(const Piece& piece, int first_row, int last_row, int top, std::vector<float>& sums) const;

  const SheetColours& colours_;
  int width_, height_, samples_, band_;
  PixelBox box_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<int>> of_band_;  // pieces that may touch each band, ascending
};

}  // namespace vacuform
