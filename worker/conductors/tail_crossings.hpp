// Where a tail goes over the traces of other loops, and how far its bridges reach.
#pragma once

#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/conductors/part_line.hpp"
#include "worker/conductors/tails.hpp"

namespace vacuform {

// The leads of a tail, mm on the part.
struct LeadSizes {
  double width_mm = 0, between_mm = 0;
  double port_mm = 0;    // between the leads at the port
  double trace_mm = 0;   // width of the loop's trace
  double spread_mm = 4;  // over which the leads spread from the port, and to the pads
  double pad_length_mm = 3, pad_width_mm = 0, pitch_mm = 0;  // of the pads

  double pair_mm() const { return between_mm + 2 * width_mm; }
  double field_mm() const { return pitch_mm + pad_width_mm; }
};

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
