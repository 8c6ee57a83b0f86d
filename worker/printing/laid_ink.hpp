// The ink of a print where it lies on the flat sheet, on pixels of a quarter of a millimetre or more. Internal to
// worker/printing.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "worker/placement/charted_surface.hpp"
#include "worker/printing/row_source.hpp"

namespace vacuform {

class LaidInk {
 public:
  // The grid for a sheet of this size: at most 2000 pixels per side.
  static PrintGrid grid_of(double width_mm, double height_mm);

  // `grid` is that of the source.
  LaidInk(const RowSource& source, const PrintGrid& grid);
  // Adds the ink of another layer on the same grid.
  void add(const LaidInk& other);

  // The share of the ink, by its area on the formed surface, that lies on the chart; 1 without any ink.
  double share_on(const ChartedSurface& charted) const;
  // Whether there is ink in a box of the sheet.
  bool any_in(const Eigen::AlignedBox2d& rest) const;
  // Whether there is ink closer than `mm` to a place of the sheet.
  bool any_near(const Eigen::Vector2d& rest, double mm) const;

 private:
  PrintGrid grid_;
  std::vector<std::uint8_t> ink_;  // 0 none to 255 black, rows from the top
};

}  // namespace vacuform
