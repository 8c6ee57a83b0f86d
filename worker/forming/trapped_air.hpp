// Air that the sheet traps between itself and the mold, computed from the contact times of the sheet.
//
// The vacuum drains the platform and the space below the frame. It does not drain a free region of the sheet whose
// border sticks to the mold completely before it fills. These regions are branches of the merge tree of contact time
// (Carr, Snoeyink, Axen 2003, "Computing contour trees in all dimensions"): vertices enter latest first, and the branch
// that has grown around a late vertex when it meets the drained part is a pocket.
#pragma once

#include <vector>

#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// Limits of a pocket. Smaller ones are one or two cells of the grid, or a dent so shallow that its air does not matter.
struct PocketLimits {
  double area_mm2 = 25;  // of the formed sheet
  std::size_t vertices = 3;
  double depth_mm = 0.5;
};

// Vertices of one pocket, the last to touch first; among those that never touch, the one highest above the mold first.
struct Pocket {
  std::vector<int> vertices;
  double area_mm2 = 0;                   // of the formed sheet
  double depth_mm = 0;                   // of the formed sheet below the film that spans the border
  double closed = 0;                     // contact time at which it closed
  std::vector<std::vector<int>> basins;  // parts that separated from the rest before they filled
};

// The pockets, largest first. `mold` gives the distance from a free sheet down to the mold; it may be empty. O(n log
// n). Deterministic.
std::vector<Pocket> trapped_air(const FormedSheet& sheet, const TriangleMesh& mold,
                                const PocketLimits& limits = {});

// Where to drill: the points on the mold where the air of each pocket and basin would leave last, at least 25 mm from
// each other within a pocket. Every pocket has at least one. 1 mm wide for sheets up to 2 mm, half the thickness for
// thicker sheets.
std::vector<Vent> vents_for(const std::vector<Pocket>& pockets, const FormedSheet& sheet,
                            const TriangleMesh& mold, double sheet_thickness_mm);

}  // namespace vacuform
