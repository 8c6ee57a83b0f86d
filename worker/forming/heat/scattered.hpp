// A temperature field through a handful of measured points.
#pragma once

#include <vector>

#include "worker/forming/heat/temperature_field.hpp"

namespace vacuform {

struct MeasuredPoint {
  Eigen::Vector2d sheet;  // (s, t), mm
  double celsius;
};

// The smoothest surface through the points (thin-plate spline; Duchon 1977), held within their least and greatest
// temperature, so that it does not run away beyond them; on a raster of about 5 mm. One point, or points of one
// temperature, give a uniform field. Points closer together than the sheet's size / 25, when there are more than 400,
// are merged into their mean; so are points less than 0.5 mm apart. At least one point; all finite. Deterministic.
TemperatureField through_points(const std::vector<MeasuredPoint>& points, double width_mm, double height_mm);

}  // namespace vacuform
