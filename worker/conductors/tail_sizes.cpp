#include "worker/conductors/tail_sizes.hpp"

#include <algorithm>

#include "worker/conductors/gap_layout.hpp"

namespace vacuform {

namespace {

// The pins of headers and small connectors are that far apart.
constexpr double least_pitch_mm = 2.54, least_pad_mm = 1.5, between_pads_mm = 1;
// Leads that lie farther apart would be a loop of their own.
constexpr double most_between_mm = 3;

}  // namespace

LeadSizes lead_sizes(const CoilSettings& settings, double port_mm, double trace_mm) {
  LeadSizes out;
  out.width_mm = settings.tail_width_mm;
  out.port_mm = port_mm;
  out.between_mm = std::clamp(port_mm, std::min(settings.clearance_mm, most_between_mm), most_between_mm);
  out.trace_mm = trace_mm;
  out.pad_width_mm = std::max(least_pad_mm, settings.tail_width_mm);
  out.pitch_mm =
      std::max(least_pitch_mm, out.pad_width_mm + std::max(between_pads_mm, settings.clearance_mm));
  return out;
}

double tail_margin_mm(const CoilSettings& settings) {
  return std::max(settings.clearance_mm, settings.patch_margin_mm);
}

double tail_room_mm(const CoilSettings& settings) {
  if (settings.tails == TailExit::none) return 0;
  constexpr double corners_mm = 0.7;  // of patches, which are taken for rounded ones
  return lead_sizes(settings, pads_of(settings).gap, 0).pair_mm() / 2 + tail_margin_mm(settings) +
         tail_slack_mm + corners_mm;
}

}  // namespace vacuform
