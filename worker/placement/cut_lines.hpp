// Cuts that the user requests (pattern.seams), inserted as edges of the triangulation of the sheet, so that segments
// can end there.
#pragma once

#include <vector>

#include "worker/flattening/flattening.hpp"
#include "worker/placement/chart_pieces.hpp"

namespace vacuform {

// The same surface, chart and print: triangles that a cut crosses are divided along it, and all values at the new
// vertices are interpolated linearly. New vertices and triangles come after the existing ones.
struct CutSheet {
  FormedSheet sheet;
  InkedSurface surface;
  Flattening flattening;
  std::vector<Edge> edges;  // of the cuts, ascending
};

// Each row x, y, z, x, y, z is a cut from the point of the inked surface of the chart nearest to the first place to the
// one nearest to the second, along the shortest path over the chart. A cut passes through vertices within a tenth of an
// edge of it, which avoids slivers: it deviates from the straight path by that much at most. A point off the chart is
// moved to its rim. Rows are cut in order; one that meets an earlier one shares its vertices. About 0.2 s per row on a
// head at 1.5 mm. Deterministic. Errors: bad_settings, naming the row (further than 20 mm from the chart; from a point
// to itself; no path), cancelled.
Result<CutSheet> with_cut_lines(FormedSheet sheet, InkedSurface surface, Flattening flattening,
                                const std::vector<std::array<double, 6>>& rows, const Context& context);

}  // namespace vacuform
