// Rows of a layer that is black wherever a predicate of sheet coordinates holds.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/printing/row_source.hpp"

namespace vacuform {

template <class Holds>
class PaintedRows : public RowSource {
 public:
  PaintedRows(const PrintGrid& grid, Holds holds) : grid_(grid), holds_(holds) {}
  PixelBox box() const override { return {0, 0, grid_.width, grid_.height}; }
  int band_rows() const override { return 50; }
  int channels() const override { return 1; }
  std::vector<std::uint8_t> rows(int top, int bottom) const override {
    std::vector<std::uint8_t> gray;
    for (int j = top; j < bottom; ++j)
      for (int i = 0; i < grid_.width; ++i)
        gray.push_back(holds_(Eigen::Vector2d((i + 0.5 - 0.5 * grid_.width) * grid_.pixel_mm,
                                              (0.5 * grid_.height - j - 0.5) * grid_.pixel_mm))
                           ? 0
                           : 255);
    return gray;
  }

 private:
  const PrintGrid grid_;
  const Holds holds_;
};

}  // namespace vacuform
