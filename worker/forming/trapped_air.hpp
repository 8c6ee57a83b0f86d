// Air that the sheet shuts in between itself and the mold, from the times at which the sheet touched.
//
// The vacuum drains the platform and the space below the frame; it does not drain a free region of the sheet whose
// border is wholly stuck to the mold before it fills. These regions are branches of the merge tree of contact time
// (Carr, Snoeyink, Axen 2003, "Computing contour trees in all dimensions"): vertices enter latest first, and what has
// grown around a late vertex when it meets the drained part is what was shut in there.
#pragma once

#include <vector>

#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// What is less is no pocket: one or two cells of the grid, or a dent so shallow that its air does not matter.
struct PocketLimits {
  double area_mm2 = 25;  // of the formed sheet
  std::size_t vertices = 3;
  double depth_mm = 0.5;
};

// Vertices that were shut in together, the last to touch first; of those that never touch, the one highest above the
// mold first.
struct Pocket {
  std::vector<int> vertices;
  double area_mm2 = 0;                   // of the formed sheet
  double depth_mm = 0;                   // of the formed sheet below the film that spans the border
  double closed = 0;                     // contact time at which it was shut in
  std::vector<std::vector<int>> basins;  // parts of it that were parted from the rest before they filled
};

// The pockets, largest first. `mold` tells how far below a free sheet it lies; it may be empty. O(n log n).
// Deterministic.
std::vector<Pocket> trapped_air(const FormedSheet& sheet, const TriangleMesh& mold,
                                const PocketLimits& limits = {});

// Where to drill: where the air of each pocket and basin would leave last, on the mold, not nearer than 25 mm to each
// other within a pocket; every pocket has at least one. 1 mm wide for sheets up to 2 mm, half a thicker sheet's thickness.
std::vector<Vent> vents_for(const std::vector<Pocket>& pockets, const FormedSheet& sheet,
                            const TriangleMesh& mold, double sheet_thickness_mm);

}  // namespace vacuform
