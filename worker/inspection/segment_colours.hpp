// Segments and seams on the formed sheet. Internal to worker/inspection.
#pragma once

#include "worker/inspection/inspection.hpp"
#include "worker/inspection/view.hpp"

namespace vacuform {

// What preview-segments.png shows at a place: each segment in a colour that none of its neighbours has, seams dark, the
// drawing's ink over it. The job has a placement, to which this keeps a reference.
class SegmentColours {
 public:
  explicit SegmentColours(const Finished& job);
  // Nothing off the segments.
  std::optional<Rgb> operator()(const Seen& seen) const;

 private:
  struct Face {
    int colour = -1;                    // -1: off the segments
    std::array<bool, 3> seam{};         // the edges opposite the corners
    std::array<double, 3> height_mm{};  // of the corners over those edges
  };
  std::vector<Face> faces_;  // of the sheet
};

}  // namespace vacuform
