// The ink of a print where it lies on the flat sheet, on pixels of a quarter of a millimetre or more. Internal to
// worker/printing.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/placement/charted_surface.hpp"
#include "worker/printing/row_source.hpp"

namespace vacuform {

class LaidInk {
 public:
  // The grid that a source must use: the size of the sheet, at most 2000 pixels per side.
  struct Grid {
    int width, height;
    double pixel_mm;
    Grid(double width_mm, double height_mm);
  };
  // `channels` of the source: 1 gray on white, 4 RGBA.
  LaidInk(const RowSource& source, const Grid& grid, int channels);
  // Ink of another layer of the same sheet.
  void add(const RowSource& source, int channels);

  // The share of the ink, by its area on the formed surface, that lies on the chart; 1 without any ink.
  double share_on(const ChartedSurface& charted) const;
  // Whether there is ink closer than `mm` to a place of the sheet.
  bool any_near(const Eigen::Vector2d& rest, double mm) const;

 private:
  Grid grid_;
  std::vector<std::uint8_t> ink_;  // 0 none to 255 black, rows from the top
};

}  // namespace vacuform
