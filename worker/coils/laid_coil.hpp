// Elements on the surface as circuits.
#pragma once

#include <optional>

#include "worker/coils/coupling_matrix.hpp"
#include "worker/placement/element_layout.hpp"

namespace vacuform {

struct LaidCoil {
  ElementOnSurface element;
  double self_nh = 0;  // inductance of its loop; 0 without a loop
};

// For the elements of a layout, in their order.
std::vector<LaidCoil> with_inductances(const ElementLayout& layout, std::vector<ElementOnSurface> laid);

// The elements of a layout where their centres are now; `rough` as in element_patch(). Errors: cancelled.
Result<std::vector<LaidCoil>> lay_coils(const ChartedSurface& charted, const ElementLayout& layout,
                                        const Context& context, bool rough = false);

// M / sqrt(L1 L2); nothing unless both have a loop.
std::optional<double> coupling(const LaidCoil& a, const LaidCoil& b);

// Of every coil with every other, while Stage::printing runs; empty for more than most_coupled_coils. Errors: cancelled.
Result<CouplingMatrix> coupling_matrix(const std::vector<LaidCoil>& coils, const Context& context);

}  // namespace vacuform
