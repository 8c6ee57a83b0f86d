// Which of two loops that cross on one face goes over the other, and how far its bridge reaches.
//
// The lower loop stays whole. A dielectric patch along it covers the crossing. The upper loop is interrupted there, and a
// bridge of a second conductor over the patch joins its ends.
#pragma once

#include <functional>
#include <vector>

#include "worker/conductors/crossings.hpp"
#include "worker/conductors/trace.hpp"

namespace vacuform {

// Millimetres on the formed part.
struct BridgeSizes {
  double margin = 0.5;     // of the patch beyond both conductors
  double overlap = 1.5;    // of the bridge on each end of the loop below it
  double clearance = 0.5;  // least distance of conductors of different loops
};

// Lengths along the loops in the drawing, mm, to each side of the crossing.
struct Bridge {
  Crossing crossing;
  bool a_over = false;  // the upper loop is crossing.a, otherwise crossing.b
  double cut = 0;       // of the upper loop: nothing of it within
  double reach = 0;     // of the upper loop: half of the bridge
  double patch = 0;     // of the lower loop: half of the patch

  int over() const { return a_over ? crossing.a : crossing.b; }
  int under() const { return a_over ? crossing.b : crossing.a; }
  double along_over() const { return a_over ? crossing.along_a : crossing.along_b; }
  double along_under() const { return a_over ? crossing.along_b : crossing.along_a; }
};

// For each crossing, in their order. `trace_of` gives the loop of an element. The end of a bridge must lie on its loop and
// not on the patch of another crossing: no change of a single choice leaves fewer that do not. `crowded` counts those that
// are left. Deterministic; O(n log n) in the crossings of a loop for each round, at most 50.
struct Bridges {
  std::vector<Bridge> bridges;
  int crowded = 0;
};
Bridges choose_bridges(const std::vector<Crossing>& crossings,
                       const std::function<const Trace&(int)>& trace_of, const BridgeSizes& sizes);

}  // namespace vacuform
