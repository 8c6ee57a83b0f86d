// Pieces of ink that hang together on the flat sheet.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "worker/pattern/area.hpp"

namespace vacuform {

class Islands {
 public:
  Islands() = default;
  // Of what the rings cover together, sheet coordinates, mm.
  explicit Islands(const std::vector<Ring>& rings);

  int count() const { return static_cast<int>(outlines_.size()); }
  // The outer outline of each and its holes, as an area.
  const std::vector<Area>& outlines() const { return outlines_; }
  // The one that covers a point; -1: none. Linear in the edges at the height of the point.
  int at(const Eigen::Vector2d& p) const;

 private:
  struct Edge {
    Eigen::Vector2d low, high;
    int island, winding;
  };
  std::vector<Area> outlines_;
  std::map<long, std::vector<Edge>> rows_;  // edges by the rows that they reach into, and by island in each
};

}  // namespace vacuform
