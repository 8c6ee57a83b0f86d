// A region cut into charts of little distortion: for figurines, saddles, and pictures that no single chart can carry.
//
// Each segment is flattened by itself and laid in the pattern where the one chart of the whole region has it, so that a
// drawing made for the region falls onto each segment nearly undistorted; across a seam it jumps, and by how much is
// told. On the sheet neighbours meet without gap or overlap: they share the seam's edges.
#pragma once

#include <vector>

#include "worker/placement/chart_pieces.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// A part of the region of interest that is laid in the pattern as a whole.
struct Segment {
  Patch patch;
  std::vector<int> triangles;  // of the region, ascending; parallel to patch.triangles
  double distortion = 1;       // see below
};

// An edge (0 1), (1 2) or (2 0) of a triangle of the region, and the same edge of the triangle beside it.
struct SeamEdge {
  int triangle, edge, beside, beside_edge;
};

struct Seam {
  int a = 0, b = 0;      // the segments on its sides, a < b; a = b for a slit that ends within one
  double length_mm = 0;  // on the inked surface
  double mean_jump_mm = 0, max_jump_mm = 0;  // between its two sides in the pattern
  Eigen::Vector3d place{0, 0, 0};            // its vertex nearest to its middle, mm
  std::vector<SeamEdge> edges;               // seen from a
};

struct Segments {
  std::vector<Segment> parts;  // in the order of their first triangles in the chart
  std::vector<Seam> seams;     // by a, then b
  bool cuts_sufficed = true;   // no piece that the given cuts leave had to be cut further
};

// The distortion of a segment is infinite where it lies over itself in the pattern. Else, and that of a patch, it is the 95th percentile by inked area of max(s1, 1 / s2), s1 >= s2 the singular values of
// the map from the pattern to the surface, at `scale` surface millimetres a millimetre of pattern; 1 is none.
double patch_distortion(const Patch& patch, double scale);

// Cuts along `cuts` (edges of the chart's vertices, ascending), and then until every segment is below `limit` or has fewer
// than 32 triangles: into halves, as long as needed; then neighbours are joined again where the two together stay below the
// limit and about where the chart has them, but never over a given cut. Each segment is flattened as rigidly as possible from the chart's own
// coordinates and moved rigidly so that the seams' sides come near each other (least squares). About a second for a
// head at 1.5 mm. Deterministic. Errors: cancelled.
Result<Segments> cut_into_segments(const Patch& chart, double scale, double limit,
                                   const std::vector<Edge>& cuts, const Context& context);

}  // namespace vacuform
