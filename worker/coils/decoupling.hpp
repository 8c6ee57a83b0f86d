// Loops moved and resized until neighbours no longer couple on the real surface.
#pragma once

#include "worker/coils/laid_coil.hpp"

namespace vacuform {

// Changes the centres and sizes of the layout's loops so that the coupling of all its pairs of loops vanishes, as near as
// possible to where and as large as they were, and no size by more than `size_limit` (a ratio). Levenberg and
// Marquardt's method with the sizes in their bounds. Where the surface does not let all vanish, the largest is made
// small. The array as a whole stays where it was laid, and on the head, unless a pair would then stay coupled by 0.01; pairs
// of which one is off the head hardly count. `laid` is the layout on the surface, before and, on return, after. Stops once
// every pair's |k| is below 0.001 or nothing more is gained: some tenths of a second for 19 loops, some seconds where
// not all can vanish. Deterministic. Errors: cancelled.
Result<void> decouple(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
                      double size_limit, const Context& context);

}  // namespace vacuform
