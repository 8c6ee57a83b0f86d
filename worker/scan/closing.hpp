// Closes a skin: removes scraps around broken edges, fills holes, and builds walls around the opening over the
// platform.
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

// Closes an upright, oriented skin. First removes the triangles at edges that more than two triangles share, or that
// two triangles run along in the same direction. An opening is large if it measures more than a quarter of the skin
// across. It lies over the platform if its missing face would look down by at least 30 degrees. Openings with both
// properties get walls straight down to 1 mm below the lowest point of the skin and a flat cap there. Every other
// opening is filled. If two or more pieces have wide openings, they are patches of one surface: they are not closed but
// left for wrapping.
Closing close_skin(const TriangleMesh& skin);

// Triangles that fill a loop (the direction of border_loops). Uses only the vertices of the loop. Empty if no such
// filling exists. Liepa 2003, "Filling holes in meshes", as CGAL implements it.
std::vector<Triangle> fill_hole(const std::vector<Eigen::Vector3d>& vertices, const std::vector<int>& loop);

}  // namespace vacuform
