// The part of the formed sheet that is flattened.
#pragma once

#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/surface/inked_surface.hpp"

namespace vacuform {

// The largest connected part of the sheet that lies on the mold, including its holes: triangles, ascending. Empty if
// nothing lies on the mold.
std::vector<int> region_of_interest(const FormedSheet& sheet, const InkedSurface& surface);

// A point of the sheet: a triangle of it and barycentric weights of its corners.
struct Spot {
  int triangle = -1;  // of FormedSheet::triangles; -1: none
  Eigen::Vector3d corners;
  bool exact = true;  // false: the point of the region nearest to the requested point
};
// Where the vertical through `top` meets the inked surface of the region, at the highest point; within 1e-6 mm of the
// vertical also where the surface is vertical. The region is not empty.
Spot spot_below(const InkedSurface& surface, const std::vector<int>& region, const Eigen::Vector3d& top);
// The point of the region at `st` of the flat sheet.
Spot spot_at_rest(const FormedSheet& sheet, const std::vector<int>& region, const Eigen::Vector2d& st);

}  // namespace vacuform
