// A triangle of which some sides have a vertex in the middle, cut into triangles that fit their neighbours.
#pragma once

#include <array>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// middles[k]: the vertex on the side from corner k to the next, or -1 for none. One to four pieces, oriented like the
// triangle; without middles, the triangle itself. Pure.
std::vector<Triangle> pieces_of(const Triangle& corners, const std::array<int, 3>& middles);

}  // namespace vacuform
