// A chart as triangles with neighbours, to be cut into pieces. Internal to worker/placement.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "worker/placement/patch.hpp"

namespace vacuform {

using Edge = std::pair<int, int>;  // vertices, the lower first
using Faces = std::vector<int>;    // triangles of a region, ascending

struct Region {
  // Keeps a reference to the chart. Over the edges `cuts` (of its vertices; ascending) no piece passes.
  Region(const Patch& of, const std::vector<Edge>& cuts);

  const Patch& chart;
  // Neighbours over the edges (0 1), (1 2), (2 0); -1 at the border, and with `across` at cuts too.
  std::vector<std::array<int, 3>> beside, across;
  std::vector<Eigen::Vector3d> middle;
  std::vector<double> area;
};

// The pieces of `faces` that hang together, in the order of their first triangles.
std::vector<Faces> connected(const Region& region, const Faces& faces);

// Two pieces, or more where a half does not hang together: each triangle goes with the nearer of the two triangles
// farthest from each other, which are moved to the halves' middles (Lloyd). Deterministic.
std::vector<Faces> halves(const Region& region, const Faces& faces);

// The part of the chart that these triangles are, in their order. A vertex on a cut is there once for each side of it.
Patch part_of(const Region& region, const Faces& faces);

}  // namespace vacuform
