// Shades that stay what they were drawn: ink spreads with the plastic. Internal to worker/printing.
#pragma once

#include <vector>

#include "worker/pattern/pattern.hpp"
#include "worker/placement/patch.hpp"

namespace vacuform {

// By how much, for each patch, the coverage of each of its triangles is to be multiplied, so that every shade has the coverage that
// was drawn once the sheet is formed, or all of them the same share of it. Where the sheet's area grows by a, printed ink
// of coverage c covers c / a: the gain is a. Where a c would pass full ink anywhere, all gains are made smaller by the
// largest a c, so that shades keep their proportions. Empty where there is nothing to act on: a coloured drawing, or
// one whose ink is all black but for its edges (less than 1 % of the ink that is sampled lies in even shades).
std::vector<std::vector<double>> ink_gain(const std::vector<const Patch*>& patches, const Pattern& pattern);

}  // namespace vacuform
