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
  // Keeps a reference to the chart. No piece crosses the edges `cuts` (of its vertices; ascending).
  Region(const Patch& of, const std::vector<Edge>& cuts);

  const Patch& chart;
  // Neighbours over the edges (0 1), (1 2), (2 0); -1 at the border, and with `across` at cuts too.
  std::vector<std::array<int, 3>> beside, across;
  std::vector<Eigen::Vector3d> middle;
  std::vector<double> area;
};

// The connected pieces of `faces`, in the order of their first triangles.
std::vector<Faces> connected(const Region& region, const Faces& faces);

// Two pieces, or more if a half is not connected: each triangle belongs to the nearer of the two triangles farthest
// from each other, which are moved to the centres of the halves (Lloyd). Deterministic.
std::vector<Faces> halves(const Region& region, const Faces& faces);

// The part of the chart with these triangles, in their order. A vertex on a cut occurs once for each side of the cut.
Patch part_of(const Region& region, const Faces& faces);

}  // namespace vacuform
