// Whether neighbouring segments meet on the flat sheet. Internal to worker/printing.
#pragma once

#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

// Of each of the placement's seams, mm: points along it, a tenth of an edge apart, are taken to the pattern by the segment
// on either side and from there to the sheet, as what is drawn is; the largest distance between the two. Infinite where a
// segment's own coordinates lead nowhere.
std::vector<double> seam_gaps(const Placement& placement);

}  // namespace vacuform
