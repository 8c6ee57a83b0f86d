// Bends the formed sheet to the mold between its vertices.
#pragma once

#include "worker/forming/contact.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// The triangles of the sheet are flat, the mold is not: between vertices that touch the mold, the mold passes through
// them or they stand off it. Every edge between two such vertices gets a vertex in its middle if the mold is more than
// 0.02 mm off it there, but less than a twentieth of the edge and a tenth of the height of the triangles over it: in space
// on the mold, along the normal of the sheet; on the flat sheet in the middle of the edge, as the cubic with the
// gradients at both ends has it (Hermite interpolation). Beside free sheet and edges of the mold a vertex has no gradient:
// there the parabola with one of them counts, or the straight line.
//
// Where the mold has a crest over an edge (a rim between two faces, of up to 90 degrees) of more than `rim_mm`, the edge
// gets its vertex on the crest. On the flat sheet it divides the edge as it does in space. A triangle that a corner of
// the mold stands out of by more than `rim_mm` gets a vertex there. What would turn a piece over is left out, and
// what would divide a triangle very unevenly, unless the crest stands out by more than 0.3 mm. All is repeated on the pieces, three times at most.
//
// The triangles beside the edge are split; each piece keeps its plastic. What stands out further is smaller than the grid:
// it stays, and is reported (SurfaceFit).
//
// The facets of a scan are all small crests: `rim_mm` is small for a model only.
//
// New vertices and triangles come after the others. Sets all but `thickness`. Deterministic.
void bend_to_mold(FormedSheet& sheet, const Obstacles& obstacles, const TemperatureField& temperature,
                  double rim_mm);

}  // namespace vacuform
