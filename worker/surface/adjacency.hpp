// Neighbourhoods in a triangulation whose triangles all have the same orientation.
#pragma once

#include <span>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Sides are numbered 3 * triangle + k, where k is the corner opposite; a side runs from corner k + 1 to corner k + 2.
// Gives for each side the number of the same edge in the neighbour; -1 at the border, and where more than two triangles
// meet. Sorts the sides.
std::vector<int> opposite_sides(const std::vector<Triangle>& triangles);

// The border as loops of vertices, counter-clockwise around the triangles, in ascending order of the first vertex.
std::vector<std::vector<int>> border_loops(const std::vector<Triangle>& triangles);

// The triangles around each vertex. Made in two passes over the triangles.
class VertexFans {
 public:
  VertexFans(const std::vector<Triangle>& triangles, std::size_t vertices);

  // The two other corners of each triangle at v, in the order of the triangles, as pairs that make counter-clockwise
  // triangles with v. A neighbour of v appears twice, except on the border.
  std::span<const int> around(int v) const {
    const auto at = static_cast<std::size_t>(v);
    return {corners_.data() + first_[at], static_cast<std::size_t>(first_[at + 1] - first_[at])};
  }

 private:
  std::vector<int> first_, corners_;
};

// The triangles at each vertex, ascending. Made in two passes over the triangles.
class VertexTriangles {
 public:
  VertexTriangles(const std::vector<Triangle>& triangles, std::size_t vertices);

  std::span<const int> around(int v) const {
    const auto at = static_cast<std::size_t>(v);
    return {of_vertex_.data() + first_[at], static_cast<std::size_t>(first_[at + 1] - first_[at])};
  }

 private:
  std::vector<int> first_, of_vertex_;
};

}  // namespace vacuform
