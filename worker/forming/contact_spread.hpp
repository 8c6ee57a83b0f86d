// How fast contact spreads over the sheet.
#pragma once

#include <vector>

#include "worker/forming/process.hpp"

namespace vacuform {

class ContactSpread {
 public:
  explicit ContactSpread(const SheetGrid& grid);

  // The part of the straight ways from state.x to y, in (0, 1], within which contact spreads by one row of vertices: up
  // to the first vertex that would touch only after a neighbour of its own that was free before. Vertices that begin a
  // patch of contact for themselves count as its first row. 1 when there is none.
  double one_row(const Process& process, const SheetState& state, const Points& y,
                 const SheetAsObstacle& ceiling);

 private:
  std::vector<int> start_, neighbour_;  // of each vertex
};

}  // namespace vacuform
