// How fast contact spreads over the sheet.
#pragma once

#include "worker/forming/process.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

class ContactSpread {
 public:
  explicit ContactSpread(const SheetGrid& grid) : fans_(grid.triangles, grid.rest.size()) {}

  // The part of the straight paths of the landings, in (0, 1], within which contact spreads by one row of vertices: up
  // to the first vertex that would touch only after one of its neighbours that was free before. Vertices that start a
  // new patch of contact count as its first row. 1 when there is no such vertex.
  double one_row(const SheetState& state, std::vector<SheetState::Landing> landings) const;

 private:
  VertexFans fans_;
};

}  // namespace vacuform
