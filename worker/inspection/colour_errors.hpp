// How far the colours of a scan lie off their place on the formed part, and how different they look, measured through
// the pixels of the print.
//
// Places of the sheet are examined on an even grid of print pixels, at most 1 mm apart, each a quarter of a pixel off
// the centre of its pixel. The pixel gives the colour that shows there, as the file of the print has it, and the places
// of the scan from which the raster took that colour; their mean is the pixel's origin. The triangles of the sheet give
// the formed place, on the face that lies on the mold. Neither side knows of the other, so a shift, a mirroring or a
// jump in the print shows as an error. The simulated sheet itself is taken as true.
#pragma once

#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// Errors of registration that people make when they lay a print onto the machine by its marks.
inline constexpr double register_errors_mm[] = {0.5, 1};

// Of the coloured layer of the print, whose PNG file must be one that make_print() wrote. `resolution_mm` is the spacing of
// the sheet's grid. Deterministic for any number of threads. Errors: cancelled.
Result<ColourErrors> colour_errors(const Print& print, double resolution_mm, const Context& context);

}  // namespace vacuform
