// Compensates shades for stretch: ink spreads with the plastic. Internal to worker/printing.
#pragma once

#include <vector>

#include "worker/pattern/pattern.hpp"
#include "worker/placement/patch.hpp"

namespace vacuform {

// The factor on the ink coverage of each triangle, for each patch. With it every shade has its drawn coverage once the
// sheet is formed, or all shades have the same share of it. Where the area of the sheet grows by a, printed ink of
// coverage c covers c / a, so the gain is a. If a c would exceed full ink anywhere, all gains are reduced by the
// largest a c, so that shades keep their proportions. Empty if there is nothing to compensate: a coloured drawing, or
// one whose ink is all black except for its edges (less than 1 % of the sampled ink lies in even shades).
std::vector<std::vector<double>> ink_gain(const std::vector<const Patch*>& patches, const Pattern& pattern);

}  // namespace vacuform
