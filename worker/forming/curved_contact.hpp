// Bends the formed sheet to the mold between its vertices.
#pragma once

#include "worker/forming/contact.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// The triangles of the sheet are flat, the mold is not: between vertices that touch the mold, the mold passes through
// them or they stand off it. Every edge between two such vertices whose middle is more than 0.03 mm, but less than a tenth
// of the edge, off the mold gets a vertex there: on the flat sheet in the middle of the edge, in space on the mold, along
// the normal of the sheet. The triangles beside the edge are split. What is further off is more than the curvature that
// the grid can follow: it stays, and is reported (SurfaceFit).
//
// Needs and extends triangles, rest, formed, contact, contact_time, temperature and element_wrinkled. New vertices and
// triangles come after the others. Deterministic.
void bend_to_mold(FormedSheet& sheet, const Obstacles& obstacles);

}  // namespace vacuform
