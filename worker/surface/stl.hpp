// Writes a mesh as a file for 3D printers.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Binary STL, mm, header "Vacuform mold, mm". Coordinates are rounded to single precision.
std::vector<std::uint8_t> stl_bytes(const TriangleMesh& mesh);

}  // namespace vacuform
