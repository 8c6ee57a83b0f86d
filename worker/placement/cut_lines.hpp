// Cuts that the user asks for (pattern.seams), made edges of the sheet's triangulation, so that segments can end there.
#pragma once

#include <vector>

#include "worker/flattening/flattening.hpp"
#include "worker/placement/chart_pieces.hpp"

namespace vacuform {

// The same surface, chart and print: triangles that a cut crosses are divided along it, and everything on the new vertices
// is interpolated linearly. New vertices and triangles come after those of before.
struct CutSheet {
  FormedSheet sheet;
  InkedSurface surface;
  Flattening flattening;
  std::vector<Edge> edges;  // of the cuts, ascending
};

// Each row x, y, z, x, y, z is cut from the point of the chart's inked surface nearest to the first place to that nearest
// to the second, along the shortest way over the chart. A cut passes through vertices within a tenth of an edge of it, so
// that no slivers arise: it leaves the straight way by that much at most. A point off the chart is on its rim. Rows are cut
// in their order; one that meets an earlier one shares its vertices. About 0.2 s a row on a head at 1.5 mm. Deterministic.
// Errors: bad_settings, naming the row (further than 20 mm from the chart; from a point to itself; no way), cancelled.
Result<CutSheet> with_cut_lines(FormedSheet sheet, InkedSurface surface, Flattening flattening,
                                const std::vector<std::array<double, 6>>& rows, const Context& context);

}  // namespace vacuform
