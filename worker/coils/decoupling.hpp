// Moves and resizes loops until neighbours no longer couple on the real surface.
#pragma once

#include "worker/coils/laid_coil.hpp"

namespace vacuform {

// Changes the centres and sizes of the loops of the layout so that the coupling of all its pairs of loops vanishes.
// Keeps places and sizes as near as possible to the original ones, and changes no size by more than `size_limit` (a
// ratio). Uses the Levenberg-Marquardt method with bounds on the sizes. If the surface does not let all couplings
// vanish, the largest one is minimized. The array as a whole stays where it was laid, and on the head, unless a pair
// would then stay coupled by 0.01. Pairs with one loop off the head have almost no weight. `laid` is the layout on the
// surface, before and, on return, after. Stops when |k| of every pair is below 0.001 or when there is no more progress:
// some tenths of a second for 19 loops, some seconds if not all can vanish. Deterministic. Errors: cancelled.
Result<void> decouple(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
                      double size_limit, const Context& context);

}  // namespace vacuform
