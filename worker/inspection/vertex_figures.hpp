// How forming changes the flat sheet, one figure for each vertex: the values of the heat maps. Internal to
// worker/inspection.
#pragma once

#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// From the flat sheet to the inked surface, the mean over the triangles of each vertex, weighted by formed area, so
// that heat maps have no facets. NaN off the chart.
std::vector<double> anisotropy_of_vertices(const Finished& job);  // sigma1 / sigma2, at least 1
std::vector<double> area_ratio_of_vertices(const Finished& job);  // max(a, 1 / a), a = formed over flat area

}  // namespace vacuform
