// Ink that is laid on the flat sheet as a part of what a layer prints.
#pragma once

#include <vector>

#include "worker/conductors/tails.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

// Adds each area to its element, in black, with its middle as a centre line. `vectors` has the elements of the drawing. The
// outlines lie within .01 mm of the areas.
void add_laid_ink(const std::vector<LaidInkArea>& ink, VectorPrint& vectors);

}  // namespace vacuform
