// How fast contact spreads over the sheet.
#pragma once

#include "worker/forming/process.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

class ContactSpread {
 public:
  explicit ContactSpread(const SheetGrid& grid) : fans_(grid.triangles, grid.rest.size()) {}

  // The part of the straight ways from state.x to y, in (0, 1], within which contact spreads by one row of vertices: up
  // to the first vertex that would touch only after a neighbour of its own that was free before. Vertices that begin a
  // patch of contact for themselves count as its first row. 1 when there is none.
  double one_row(const Process& process, const SheetState& state, const Points& y,
                 const SheetAsObstacle& ceiling);

 private:
  VertexFans fans_;
};

}  // namespace vacuform
