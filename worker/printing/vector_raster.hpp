// A vector print in rows of pixels, drawn with anti-aliasing. Internal to worker/printing.
#pragma once

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "worker/printing/row_source.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

// Keeps a reference to the print.
class VectorRaster : public RowSource {
 public:
  VectorRaster(const VectorPrint& print, const PrintGrid& grid, bool grayscale);

  PixelBox box() const override;
  int band_rows() const override { return band_; }
  int channels() const override { return grayscale_ ? 1 : 4; }
  std::vector<std::uint8_t> rows(int top, int bottom) const override;

 private:
  struct Painted {
    const PaintedArea* area;
    double low, high;                               // t, mm
    std::vector<std::pair<double, double>> ranges;  // the same of each outline
  };
  const int width_, height_, band_;
  const double pixel_mm_;
  const bool grayscale_;
  std::vector<Painted> areas_;
  Eigen::AlignedBox2d box_;
};

}  // namespace vacuform
