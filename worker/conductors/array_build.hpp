// An array of loops as a lab can print it: loops that cross do not touch, and each has gaps for its capacitors and a port.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "worker/conductors/bridges.hpp"
#include "worker/conductors/gaps.hpp"
#include "worker/conductors/print_step.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

// A part of a drawing that is printed in one step. Its elements are those of the drawing, in their order; those without ink
// in it have no shapes.
struct BuiltLayer {
  PrintStep step = PrintStep::conductor;
  int face = 0;  // 0: that of pattern.inked_face, 1: the other
  Drawing drawing;
};

// Of a loop, in the order along it from its port.
struct LoopGap {
  int coil = 0;    // index into Drawing::elements
  Interval along;  // of its loop in the drawing (loop_path.hpp)
  bool port = false;
  bool drawn = false;              // in the drawing, and not made here
  int number = 0;                  // from 1, in the tables and on the print
  Eigen::Vector3d place{0, 0, 0};  // of its middle on the inked surface of the coil's face, mm
  Eigen::Vector2d rest{0, 0};      // the same on the flat sheet, mm
  Eigen::Vector2d inwards{1, 0};   // there, a unit vector across the trace
};

struct ArrayBuild {
  std::vector<int> faces;  // by Drawing::elements: 0 or 1
  // The placement with every element on the inked surface of the second face; nothing if no element lies there.
  std::optional<Placement> reverse;
  std::vector<BuiltLayer>
      layers;  // face by face, in the order of printing; the first has step conductor and face 0
  std::vector<Bridge> bridges;  // one where loops on one face cross; none with coils.build=single
  std::vector<LoopGap> gaps;    // by coil
  // "bridges-crowded", "gaps-left-out"
  std::vector<Warning> warnings;

  const Placement& placement(int face, const Placement& first) const { return face == 0 ? first : *reverse; }
};

// What `placement` places of `drawing`, built as settings.coils asks. `reverse`: the other face of the same sheet, with the
// same triangles. What is no loop stays as it is, on the first face, or that of the coil it follows. Deterministic.
// Errors: cancelled.
Result<ArrayBuild> build_array(const Drawing& drawing, const Placement& placement,
                               const ChartedSurface& reverse, const Settings& settings,
                               const Context& context);

}  // namespace vacuform
