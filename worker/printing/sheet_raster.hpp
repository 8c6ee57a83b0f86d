// The chart's triangles, filled with the drawing, in rows of print pixels. Internal to worker/printing.
#pragma once

#include <array>
#include <vector>

#include "worker/pattern/ink_parts.hpp"
#include "worker/pattern/pattern.hpp"
#include "worker/placement/placement.hpp"
#include "worker/printing/row_source.hpp"

namespace vacuform {

// A patch through which the drawing is sampled.
struct RasterPatch {
  static constexpr int whole = -2;
  const Patch* patch;
  int part = whole;  // of InkParts: only its ink is seen; -1: only ink of no part
  std::vector<double>
      gain;  // for the ink of each triangle, up to full coverage; empty: 1. Of a grayscale drawing only
};

// The patches that a picture is sampled through: those of its parts, and the charts for ink in no part. They point into
// the placement.
std::vector<RasterPatch> patches_of(const Placement& placement);

// Samples along a side of a pixel. Coarse grids need more for edges that look as smooth as those of fine ones.
int edge_samples(const PrintGrid& grid);

// Keeps references to its inputs. Pixels are those of the print before any mirroring; the box encloses all patches.
class SheetRaster : public RowSource {
 public:
  // `parts` may be null if every patch shows the whole. `samples` along a side of a pixel: see edge_samples().
  SheetRaster(const std::vector<RasterPatch>& patches, const InkParts* parts, const Pattern& pattern,
              const PrintGrid& grid, int samples);

  PixelBox box() const override { return box_; }
  int band_rows() const override { return band_; }
  int channels() const override { return channels_; }
  std::vector<std::uint8_t> rows(int top, int bottom) const override;

 private:
  // One triangle: its corners on the grid of samples, and the affine map from there to pattern coordinates.
  struct Piece {
    std::array<Eigen::Vector2d, 3> corners;
    Eigen::Vector2d origin, across, down;  // uv = origin + x across + y down
    double blur;
    float gain;
    int part;
  };
  void scan(const Piece& piece, int first_row, int last_row, int top, std::vector<float>& sums) const;

  const Pattern& pattern_;
  const InkParts* parts_;
  int width_, height_, channels_, samples_, band_;
  PixelBox box_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<int>> of_band_;  // pieces that may touch each band, ascending
};

}  // namespace vacuform
