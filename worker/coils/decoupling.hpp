// Moves and resizes loops until they couple as little as the real surface lets them.
#pragma once

#include "worker/coils/laid_coil.hpp"

namespace vacuform {

// Changes the centres and sizes of the loops of the layout so that its loops couple little, every one with every other:
// not at all between neighbours (its pairs, and loops that overlap), which an overlap can null, and below `unnulled_k`
// between the others, which only distance reduces and preamplifiers take care of. Keeps places and sizes as near as
// possible to the original ones, and changes no size by more than `size_limit` (a ratio). Uses the Levenberg-Marquardt
// method with bounds on the sizes; which loops are near each other is found again as they move. The array as a whole
// stays where it was laid, unless neighbours would then stay coupled by 0.01, and no loop leaves the head. Pairs with one
// loop off the head have almost no weight. `laid` is the layout on the surface, before and, on return, after: never with
// a stronger pair than before above `unnulled_k`, else both stay as they were. Stops when |k| of every pair is below
// 0.001, weighted, or when there is no more progress. Does nothing for more than most_coupled_coils loops.
// Deterministic. Errors: cancelled.
Result<void> decouple(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
                      double size_limit, const Context& context);

inline constexpr double unnulled_k = 0.03;
// Loops whose centres are nearer than this share of their radii together overlap: a place where they do not couple is near.
inline constexpr double overlap_share = 0.9;

}  // namespace vacuform
