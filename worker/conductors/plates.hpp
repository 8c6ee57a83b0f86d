// Capacitors that are printed: a plate on the other face of the sheet under each gap of a loop. With both ends of the trace,
// which are as wide there, it is two capacitors in series.
#pragma once

#include <Eigen/Core>

#include "worker/conductors/gaps.hpp"
#include "worker/conductors/trace.hpp"

namespace vacuform {

struct Plate {
  double before = 0, after = 0;  // beyond the edges of the gap, mm in the drawing
  double wanted_pf = 0;
  double pf = 0;  // of both in series on the part, with the field at the edges
  double between_pf =
      0;  // the same of the field between the plates alone: permittivity times area over thickness
  double thickness_mm = 0;     // of the sheet there, mean
  Eigen::Vector2d rest{0, 0};  // of the middle, on the flat sheet, mm
};

// How far the trace ends reach beyond a plate to all sides, so that the plate alone decides its capacitance, mm on the part.
inline constexpr double plate_margin_mm = 0.5;

// The patch of an element with the same places of the flat sheet on the other face, from the patch that the element would have
// there: what is printed on both in register lies opposite to itself.
Patch opposite(const Patch& patch, const Patch& other_face);

// As long as it must be for `wanted_pf` on the part as it is formed, within 1e-4, but no longer than the room on each side, mm
// in the drawing. `near` is the trace, `far` the same loop on the other face. Deterministic.
Plate plate_for(const Trace& near, const Trace& far, const Interval& gap, double width_mm,
                double permittivity, double wanted_pf, double room_before, double room_after);

}  // namespace vacuform
