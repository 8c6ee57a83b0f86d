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
// there the parabola with one of them counts, or the straight line. The triangles beside the edge are split; each piece
// keeps its plastic. What is further off is more than the curvature that the grid can follow: it stays, and is reported
// (SurfaceFit).
//
// New vertices and triangles come after the others. Sets all but `thickness`. Deterministic.
void bend_to_mold(FormedSheet& sheet, const Obstacles& obstacles, const TemperatureField& temperature);

}  // namespace vacuform
