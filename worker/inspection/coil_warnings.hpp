// The warnings about the coils as measured. Internal to worker/inspection.
#pragma once

#include <vector>

#include "worker/inspection/coil_figures.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

// "coil-out-of-shape": coils on the head that are farther from their drawn shape than 0.5 % of their size, worst first;
// "coils-spacing": neighbours on the head whose distances are farther from the drawn ones than 2 mm, root mean square
// (decoupling changes distances on purpose); "coils-coupled" (worker/coils/coupled_neighbours.hpp). The figures are
// those of CoilTable.
std::vector<Warning> coil_warnings(const CoilTable& table, bool decoupled);

}  // namespace vacuform
