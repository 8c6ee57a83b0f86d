// Whether neighbouring segments meet on the flat sheet. Internal to worker/printing.
#pragma once

#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

// For each seam of the placement, mm: the segments on both sides map points along it, a tenth of an edge apart, to the
// pattern and from there to the sheet, as they map the drawing. The result is the largest distance between the two.
// Infinite where the coordinates of a segment have no place on the sheet.
std::vector<double> seam_gaps(const Placement& placement);

}  // namespace vacuform
