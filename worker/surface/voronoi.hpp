// Points spread evenly over a part of the surface: a centroidal Voronoi tessellation of its vertices (Du, Faber,
// Gunzburger, "Centroidal Voronoi tessellations", SIAM Review 1999) by Lloyd's iteration with distances in space.
#pragma once

#include <utility>
#include <vector>

#include "worker/surface/inked_surface.hpp"

namespace vacuform {

struct Tessellation {
  std::vector<int> sites;                  // vertices of the sheet, one a cell, nearest to the cells' centres
  std::vector<std::pair<int, int>> touch;  // cells with a common border, a < b
};

// `vertices` with their areas. `sites` are the start, in space; they stay fixed unless `settle`. Deterministic.
Tessellation tessellate(const InkedSurface& surface, const std::vector<int>& vertices,
                        const std::vector<double>& areas, std::vector<Eigen::Vector3d> sites, bool settle);

}  // namespace vacuform
