// Metric multidimensional scaling: points of the plane with given distances.
#pragma once

#include "worker/placement/spacing.hpp"

namespace vacuform {

// Places in the plane with the distances `mm` between the pairs, in the least squares sense, near `start`, with its
// centre and its mean rotation (stress majorization: Gansner, Koren, North, "Graph drawing by stress majorization",
// 2004, by single steps). mm per pair. Deterministic.
std::vector<Eigen::Vector2d> metric_mds(const std::vector<Eigen::Vector2d>& start,
                                        const std::vector<Neighbours>& pairs, const std::vector<double>& mm);

}  // namespace vacuform
