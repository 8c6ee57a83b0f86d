// Closing a skin: scraps around broken edges removed, holes filled, the opening over the platform walled in.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

struct Closing {
  TriangleMesh mesh;             // watertight where `sound`
  int holes_closed = 0;          // filled
  int holes_capped = 0;          // large openings over the platform: walls drop from the rim to a flat cap
  double largest_filled_mm = 0;  // across
  bool sound = false;
};

// Closes an upright, oriented skin. An opening counts as large when it measures more than a quarter of the
// skin across, and as lying over the platform when its missing face would look down by at least 30 degrees;
// such openings get walls straight down to 1 mm below the skin's lowest point and a flat cap there. Every
// other opening is filled. Pieces of which two or more are open widely are patches of one surface: they are
// not closed but left to be wrapped. Triangles at edges that more than two share, or that two run along in
// the same direction, are removed first.
Closing close_skin(const TriangleMesh& skin);

// Triangles that fill a loop (the direction of border_loops). Uses only the loop's vertices. Empty when there
// is no such filling. Liepa 2003, "Filling holes in meshes", as CGAL implements it.
std::vector<Triangle> fill_hole(const std::vector<Eigen::Vector3d>& vertices, const std::vector<int>& loop);

}  // namespace vacuform
