// The colours of a scan on the flat sheet, in rows of print pixels. Internal to worker/printing and worker/inspection.
#pragma once

#include <array>
#include <vector>

#include "worker/colour/sheet_colours.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/row_source.hpp"

namespace vacuform {

// Keeps a reference to the colours. Pixels are those of the print before any mirroring, RGBA: the mean colour, in linear
// light, of the scan's surface around the point closest to the pixel; at borders of colours the mean of several parts of
// the pixel. The same bytes for any number of threads.
class ColourRaster : public RowSource {
 public:
  struct Compensation {
    const ColourInk* ink = nullptr;  // null: the colours as they are; a reference is kept
    InkState state = InkState::printed;
  };
  // `samples`: parts along each side of a pixel at a border, which is smoother with more of them: 2 for a print, 1 for a
  // picture that is shown smaller.
  ColourRaster(const SheetColours& colours, const PrintGrid& grid, Compensation compensation,
               int samples = 2);
  ColourRaster(const SheetColours& colours, const PrintGrid& grid, int samples = 2)
      : ColourRaster(colours, grid, Compensation(), samples) {}

  PixelBox box() const override { return box_; }
  int band_rows() const override { return band_; }
  int channels() const override { return 4; }
  std::vector<std::uint8_t> rows(int top, int bottom) const override;

  // Where the colour of a pixel comes from.
  struct Origin {
    Eigen::Vector3d scan =
        Eigen::Vector3d::Zero();  // mean of its places on the scan, weighted as their colours are
    double share = 0;             // of full colour, in [0, 1]; 0: the pixel has no colour
  };
  // Of every `step`-th pixel of a row, from column `first` on to the print's width. Thread safe.
  std::vector<Origin> origins(int row, int first, int step) const;

 private:
  // One triangle: its corners on the grid of samples, the affine maps from there to the formed sheet and to the area
  // ratio, and a triangle of the scan near its first corner, or -1.
  struct Piece {
    std::array<Eigen::Vector2d, 3> corners;
    Eigen::Vector3d origin, across, down;
    double ratio = 1, ratio_across = 0, ratio_down = 0;
    int start = -1;
  };
  Eigen::Vector3f inked(const Eigen::Vector3f& linear, float area_ratio) const;
  struct Strip;
  // Adds `places` x `places` parts of each pixel, where they lie in a piece, to the pixels of a strip for which
  // wanted(index in the strip).
  template <class Wanted>
  void add(const Piece& piece, int places, const Wanted& wanted, Strip& strip) const;
  std::vector<char> borders(const Strip& strip, const std::vector<int>& pieces) const;

  const SheetColours& colours_;
  Compensation compensation_;
  int width_, height_, samples_, band_;
  PixelBox box_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<int>> of_band_;  // pieces that may touch each band, ascending
};

}  // namespace vacuform
