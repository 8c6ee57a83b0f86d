// The cheapest way over the cells of a sheet (Lee 1961, with costs: Dijkstra 1959), pulled straight.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "worker/conductors/sheet_cells.hpp"

namespace vacuform {

// By cells: what a millimetre on the part costs there; 0: no way leads over it.
using WayCosts = std::vector<float>;

// From a place to the nearest cell, by cost, of which `is_end` says so; sheet coordinates, mm. A corner lies only where the
// straight line would cost more. Nothing if no way leads there. O(n log n) in the cells. Deterministic.
std::optional<std::vector<Eigen::Vector2d>> cheapest_way(const SheetCells& cells, const WayCosts& costs,
                                                         const Eigen::Vector2d& from,
                                                         const std::function<bool(int)>& is_end);

// The same line with arcs for corners, of a radius of at most `radius_mm`, and points at most .25 mm apart. An arc is made
// smaller until all its points are free.
std::vector<Eigen::Vector2d> with_round_corners(
    const std::vector<Eigen::Vector2d>& line, double radius_mm,
    const std::function<bool(std::size_t corner, const Eigen::Vector2d&)>& is_free);

}  // namespace vacuform
