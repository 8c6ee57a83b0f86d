// Where the numbers of gaps are printed. Internal to worker/printing.
#pragma once

#include <vector>

#include "worker/printing/laid_ink.hpp"
#include "worker/printing/layer.hpp"
#include "worker/printing/marks.hpp"

namespace vacuform {

// Beside its place, at least .4 mm clear of all ink and of the other numbers: as near as possible, at most 9 mm away. A
// number without such a place is left out. Texts in sheet coordinates, mirrored if the page is.
std::vector<Text> place_numbers(const std::vector<PlaceNumber>& numbers, const LaidInk& ink, bool mirrored);

}  // namespace vacuform
