// The temperature of the sheet when it meets the mold, mean through its thickness, over sheet coordinates.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vacuform {

class TemperatureField {
 public:
  // Where the samples of a raster lie: from edge to edge of the sheet, or in the middle of equal cells that tile it, as
  // the pixels of a picture do.
  enum class Samples { from_edge_to_edge, in_cells };

  explicit TemperatureField(double celsius) : width_(1), height_(1), columns_(1), celsius_{celsius} {}
  // Samples on a regular raster, row by row from the lower left (s, t least). At least one column and one row;
  // celsius.size() is a multiple of columns.
  TemperatureField(double width_mm, double height_mm, int columns, std::vector<double> celsius,
                   Samples samples = Samples::from_edge_to_edge)
      : width_(width_mm),
        height_(height_mm),
        columns_(columns),
        samples_(samples),
        celsius_(std::move(celsius)) {}

  // Bilinear between the samples; beyond the outermost, the nearest on the edge of their raster.
  double at(const Eigen::Vector2d& sheet) const;

 private:
  double width_, height_;
  int columns_;
  Samples samples_ = Samples::from_edge_to_edge;
  std::vector<double> celsius_;
};

}  // namespace vacuform
