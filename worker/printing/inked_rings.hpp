// The ink of a layer of lines as polygons.
#pragma once

#include <vector>

#include "worker/pattern/area.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

// What each painted area leaves of ink, sheet coordinates, mm: opaque white covers what is below. Counter-clockwise around ink,
// clockwise around holes; the areas of different shapes may overlap. Within the tolerance. The work is limited: of drawings with
// some thousands of white shapes on as many others, what is not taken away stays ink.
std::vector<Ring> inked_rings(const VectorPrint& vectors, double tolerance_mm);

}  // namespace vacuform
