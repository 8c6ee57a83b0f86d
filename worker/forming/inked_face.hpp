// Where the ink of a formed sheet lies.
#pragma once

#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/surface/inked_surface.hpp"

namespace vacuform {

// The face that carries the ink, one place a vertex of the sheet, mm: the formed one (inner), or the other, one thickness
// along the vertex normals.
std::vector<Eigen::Vector3d> inked_positions(const FormedSheet& sheet, InkedFace face);

// The same as the surface that all later stages work on.
InkedSurface inked_surface(const FormedSheet& sheet, InkedFace face);

constexpr InkedFace other_face(InkedFace face) {
  return face == InkedFace::outer ? InkedFace::inner : InkedFace::outer;
}

}  // namespace vacuform
