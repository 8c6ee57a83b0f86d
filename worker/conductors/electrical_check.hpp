// Whether the printed conductors of an array are the circuits that they are meant to be: one for each loop, closed by its
// capacitors, joined to no other.
//
// It looks at the ink of the print alone, not at how it was made. Resist and pictures neither join nor interrupt.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "worker/conductors/array_build.hpp"

namespace vacuform {

// What a layer of the print covers, sheet coordinates, mm.
struct PrintedInk {
  PrintStep step = PrintStep::conductor;
  int face = 0;
  std::vector<Ring> rings;
};

struct ElectricalCheck {
  struct Place {
    int a = 0, b = 0;             // indices into Drawing::elements; b = a for an open loop
    Eigen::Vector3d at{0, 0, 0};  // mm
    double mm = 0;                // distance, of those that are too close
  };
  int loops = 0;              // printed, at least in part
  int nets = 0;               // circuits that they are: as many, if all is well
  std::vector<Place> shorts;  // pairs of loops of one circuit, each once, ascending, where they meet
  std::vector<Place> opens;   // loops that are interrupted without a capacitor or a bridge, where
  std::vector<Place>
      close;  // circuits, by their first loops, nearer than the clearance on a layer, where they are nearest

  // "coils-short", "coils-open", "coils-close". The fix of shorts in a drawing with layers is about these.
  std::vector<Warning> warnings(const Drawing& drawing, double clearance_mm) const;
};

// `placement` is that of the first face, `surfaces` are of both; null: nothing lies there. A gap is closed by its
// capacitor; the plate of a printed one is a net of its own. A bridge joins what it touches outside of the dielectric. Distances are straight in space, between points
// .1 mm apart. O(n log n) in the ink. Deterministic. Errors: cancelled.
Result<ElectricalCheck> check_conductors(const Drawing& drawing, const Placement& placement,
                                         const ArrayBuild& build, const std::vector<PrintedInk>& ink,
                                         const std::array<const InkedSurface*, 2>& surfaces,
                                         double clearance_mm, const Context& context);

}  // namespace vacuform
