// The ink of an array that is no loop's trace, on the flat sheet: marks, labels, pads, lines that join coils, and in a drawing with
// layers all that is drawn over the conductors.
#pragma once

#include <functional>
#include <vector>

#include "worker/conductors/array_build.hpp"

namespace vacuform {

// The patches on which an element may lie on a face: its own, or else the charts.
using PatchOf = std::function<std::vector<const Patch*>(std::size_t element, int face)>;

// `faces` and `widest` by Drawing::elements: the face of a loop, and the width of its trace over the drawn one; 0: no loop.
// Bridges and patches that are made along loops count as well.
std::vector<LaidInkArea> ink_beside_traces(const std::vector<BuiltLayer>& layers,
                                           const std::vector<int>& faces, const std::vector<double>& widest,
                                           const PatchOf& patches);

}  // namespace vacuform
