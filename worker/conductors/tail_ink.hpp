// The ink of a tail along a line.
#pragma once

#include <optional>
#include <vector>

#include "worker/conductors/tail_crossings.hpp"

namespace vacuform {

// What a tail follows.
struct TailWay {
  const LaidLoop& loop;
  const LoopGap& port;
  std::vector<Eigen::Vector2d> line;  // from within the trace to the ends of the pads, points close together
  double start_mm = 0;                // on the part, from its beginning to the middle of the trace
  LeadSizes sizes;
  std::vector<Eigen::Vector2d> field;  // of `line`, from where the leads spread to the pads
};

struct LaidTail {
  Tail tail;
  std::vector<LaidInkArea> ink;        // of face 0
  std::vector<Eigen::Vector2d> field;  // as above
};

// Nothing if the line is too short for its bridges.
std::optional<LaidTail> lead_ink(TailWay way, const InkedSurface& surface, const PlaneLocator& locator,
                                 const std::vector<OtherTrace>& others, const Settings& settings);

}  // namespace vacuform
