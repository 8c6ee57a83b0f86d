// The sizes of the leads of a tail.
#pragma once

#include "api/settings.hpp"

namespace vacuform {

// Millimetres on the part.
struct LeadSizes {
  double width_mm = 0, between_mm = 0;
  double port_mm = 0;    // between the leads at the port
  double trace_mm = 0;   // width of the loop's trace
  double spread_mm = 4;  // over which the leads spread from the port, and to the pads
  double pad_length_mm = 3, pad_width_mm = 0, pitch_mm = 0;  // of the pads

  double pair_mm() const { return between_mm + 2 * width_mm; }
  double field_mm() const { return pitch_mm + pad_width_mm; }
};

// `port_mm`: between the leads at the port, as wide as the port's gap there.
LeadSizes lead_sizes(const CoilSettings& settings, double port_mm, double trace_mm);

// Beside a tail, from its leads to what they must not touch.
double tail_margin_mm(const CoilSettings& settings);
// Added for that a place is known by the cell that it lies in.
inline constexpr double tail_slack_mm = 0.3;

// From the middle of a port along its trace to the next bridge or patch, so that its tail has room; 0 without tails.
double tail_room_mm(const CoilSettings& settings);

}  // namespace vacuform
