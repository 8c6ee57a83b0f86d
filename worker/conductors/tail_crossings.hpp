// Where a tail goes over the traces of other loops, and how far its bridges reach.
#pragma once

#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/conductors/part_line.hpp"
#include "worker/conductors/tail_sizes.hpp"
#include "worker/conductors/tails.hpp"

namespace vacuform {

// Another loop on the face.
struct OtherTrace {
  int element = 0;
  const Trace* trace = nullptr;
  double width_mm = 0;  // on the part
};

struct CrossedTraces {
  std::vector<TailCrossing> crossings;  // by their places along the tail
  std::vector<TailBridge> bridges;      // the same; bridges that would touch are one
};

// Nothing if a bridge has no room between a crossing and an end of the tail. O(n m) in the points of the tail and in the boxes
// around parts of the traces.
std::optional<CrossedTraces> crossed_traces(const PartLine& line, const LeadSizes& sizes,
                                            const std::vector<OtherTrace>& others,
                                            const CoilSettings& settings);

}  // namespace vacuform
