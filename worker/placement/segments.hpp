// A region cut into charts of little distortion: for figurines, saddles, and pictures that no single chart can cover.
//
// Each segment is flattened separately and laid in the pattern where the one chart of the whole region has it, so a
// drawing made for the region falls onto each segment nearly undistorted. Across a seam the drawing jumps, and the size
// of the jump is reported. On the sheet neighbours meet without gap or overlap: they share the edges of the seam.
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

// An edge (0 1), (1 2) or (2 0) of a triangle of the region, and the same edge of the triangle on its other side.
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
  bool cuts_sufficed = true;   // no piece that the given cuts leave needed another cut
};

// The distortion of a segment is infinite if the segment overlaps itself in the pattern. Otherwise, and for a patch, it
// is the 95th percentile by inked area of max(s1, 1 / s2), where s1 >= s2 are the singular values of the map from the
// pattern to the surface, at `scale` surface millimetres per millimetre of pattern; 1 means no distortion.
double patch_distortion(const Patch& patch, double scale);

// Cuts along `cuts` (edges of the vertices of the chart, ascending), then halves each segment until it is below `limit`
// or has fewer than 32 triangles. Then joins neighbours again where the two together stay below the limit and about
// where the chart has them, but never over a given cut. Flattens each segment as rigidly as possible from the
// coordinates of the chart and moves it rigidly so that the sides of the seams come near each other (least squares).
// Takes about a second for a head at 1.5 mm. Deterministic. Errors: cancelled.
Result<Segments> cut_into_segments(const Patch& chart, double scale, double limit,
                                   const std::vector<Edge>& cuts, const Context& context);

}  // namespace vacuform
