// The temperature of the sheet when it meets the mold, mean through its thickness, over sheet coordinates.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vacuform {

class TemperatureField {
 public:
  explicit TemperatureField(double celsius) : width_(1), height_(1), columns_(1), celsius_{celsius} {}
  // Samples on a regular raster that covers the sheet from edge to edge, row by row from the lower left (s, t least).
  // At least one column and one row; celsius.size() is a multiple of columns.
  TemperatureField(double width_mm, double height_mm, int columns, std::vector<double> celsius)
      : width_(width_mm), height_(height_mm), columns_(columns), celsius_(std::move(celsius)) {}

  // Bilinear between the samples; beyond the sheet, that of its edge.
  double at(const Eigen::Vector2d& sheet) const;

 private:
  double width_, height_;
  int columns_;
  std::vector<double> celsius_;
};

}  // namespace vacuform
