// The large separate bodies of a scan: a file can hold two heads, or a head and its stand.
#pragma once

#include <span>
#include <vector>

#include "worker/scan/ray_caster.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Where a piece lies relative to a body, by up to 64 of its vertices and the rays from each in 14 directions: a vertex
// is inside where at least 12 meet the body, outside where at most 7 do.
struct Place {
  int samples = 0, inside = 0, outside = 0;
};
Place place_of(const TriangleMesh& piece, const RayCaster& body, double reach);

struct Body {
  int piece;                     // its index in the list given
  bool is_head;                  // it can be a head; otherwise it is a stand, a ball or a part
  Eigen::Vector3d centre, size;  // of its box
};

// The bodies among connected pieces of a scan, which are given largest diagonal first: pieces of at least two fifths of
// the largest diagonal that enclose space, neither in nor crossing a larger body. They are numbered by their centres
// along the axis of the file on which these are farthest apart. Thin shells with a wide opening, such as parts of
// a broken surface, are no bodies.
//
// A body can be a head if its box is compact (shortest side at least .35 of the longest) and filled to three tenths,
// flat faces make up less than three tenths of its area, it is not a prism or a cylinder, and not a ball. Deterministic.
std::vector<Body> find_bodies(std::span<const TriangleMesh> pieces);

}  // namespace vacuform
