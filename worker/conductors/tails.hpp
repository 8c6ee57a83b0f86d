// The tails of an array: from the port of each loop two leads, parallel on the part, to a pair of solder pads on the sheet beside
// the head.
//
// A tail leaves its port across the trace and takes the cheapest way over the flat sheet: a crossing of another loop's trace
// counts as a long way round. There the trace stays whole under a dielectric patch, and the leads go over it on bridges.
// Gaps, pads, plates, bridges, patches, other ink and other tails are not crossed.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "worker/conductors/gap_layout.hpp"
#include "worker/pattern/area.hpp"
#include "worker/placement/charted_surface.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// Where a tail goes over a trace.
struct TailCrossing {
  int under = 0;                   // the loop, index into Drawing::elements
  Interval patch;                  // along it, mm in the drawing (loop_path.hpp)
  double patch_width_mm = 0;       // on the part
  Eigen::Vector3d place{0, 0, 0};  // of its middle, mm
};
// Along a tail, mm on the part: where its leads are cut, and how far the bridges over that reach.
struct TailBridge {
  Interval cut, reach;
};

struct Tail {
  int coil = 0;    // index into Drawing::elements
  int number = 0;  // of its port (LoopGap)
  std::vector<Eigen::Vector2d>
      line;              // between its leads, from its port to the ends of its pads, sheet coordinates, mm
  double length_mm = 0;  // of that on the part, from the middle of the trace
  double between_mm = 0, width_mm = 0;    // of the leads on the part
  double squares = 0;                     // resistance of both leads over that of a square as printed
  double inductance_nh = 0;               // of both leads as a line
  double most_stretch = 1;                // along it, formed length over flat length of a millimetre
  std::array<Eigen::Vector2d, 2> pads{};  // their middles, sheet coordinates, mm
  Eigen::Vector3d place{0, 0, 0};         // between the pads, mm
  Eigen::Vector2d rest{0, 0},
      onwards{1, 0};  // the same on the flat sheet, and the direction of the tail there
  std::vector<TailCrossing> crossings;
  std::vector<TailBridge> bridges;
};

// Of both leads together, as the settings have the ink.
double tail_ohm(const Tail& tail, const CircuitSettings& settings);

// Ink that is not drawn but laid on the flat sheet.
struct LaidInkArea {
  int element = 0;  // index into Drawing::elements
  PrintStep step = PrintStep::conductor;
  int face = 0;
  Area area;                          // sheet coordinates, mm
  std::vector<Eigen::Vector2d> line;  // its middle
  double width_mm = 0;                // on the part
};

struct TailLayout {
  std::vector<Tail> tails;  // by coil
  std::vector<LaidInkArea> ink;
  std::vector<int> left_out;  // loops whose tails find no way, indices into Drawing::elements
};

// What an array has when its tails are laid.
struct ArraySoFar {
  const std::vector<LaidLoop>& loops;
  const std::vector<LoopGap>& gaps;
  const std::vector<int>& faces;               // by Drawing::elements
  std::vector<double> widest;                  // by loops: of the trace over its width
  std::array<const ChartedSurface*, 2> sides;  // by faces, with the same triangles
  std::vector<LaidInkArea> other;              // ink beside the traces
};

// As settings.coils asks. The nearest to the edge come first; if some find no way, these come first in another try. The widths
// and distances of the leads are exact on the triangles of the part where the tail is straight. Deterministic. Errors: cancelled.
Result<TailLayout> lay_tails(const ArraySoFar& array, const Settings& settings, const Context& context);

}  // namespace vacuform
