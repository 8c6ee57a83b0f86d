// An array of loops as a lab can print it: loops that cross do not touch, and each has gaps for its capacitors and a port.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "api/print_step.hpp"
#include "worker/conductors/bridges.hpp"
#include "worker/conductors/gap_layout.hpp"
#include "worker/conductors/tails.hpp"
#include "worker/conductors/widened.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

// A part of a drawing that is printed in one step, in black. Its elements are those of the drawing, in their order; those
// without ink in it have no shapes.
struct BuiltLayer {
  PrintStep step = PrintStep::conductor;
  int face = 0;  // 0: that of pattern.inked_face, 1: the other
  Drawing drawing;
  std::vector<LaidInkArea> laid = {};  // beside what is drawn, in sheet coordinates
};

struct ArrayBuild {
  std::vector<int> faces;  // by Drawing::elements: 0 or 1
  // The placement with every element on the inked surface of the second face; nothing if no element lies there. Of a loop with
  // plates on the other face than its own, that face has the loop's own places on the flat sheet: the plates lie opposite.
  std::optional<Placement> reverse;
  std::optional<Placement> first =
      {};  // instead of the given one, where loops of the second face have plates on the first
  std::vector<BuiltLayer>
      layers;  // face by face, in the order of printing; the first has step conductor and face 0
  std::vector<Bridge> bridges;        // one where loops on one face cross; none with coils.build=single
  std::vector<LoopGap> gaps;          // by coil
  std::vector<WidenedTrace> widened;  // by Drawing::elements, with print.compensate_width
  std::vector<Tail> tails;            // by coil, with coils.tails
  // "bridges-crowded", "gaps-left-out", "layer-unnamed", "loop-on-bridges", "plates-small", "tails-left-out"
  std::vector<Warning> warnings;

  const Placement& placement(int face, const Placement& given) const {
    return face == 1 ? *reverse : first ? *first : given;
  }
};

// The inked face, on which the placement lies, and the other face of the same sheet, with the same triangles.
struct SheetSides {
  const ChartedSurface &first, &reverse;
};

// What `placement` places of `drawing`, built as settings.coils asks. What is no loop stays as it is, on the first face, or that of
// the coil it follows. A drawing with layers (Drawing::layered()) is printed as they say. `body` loads the loops, for printed
// capacitors. Deterministic. Errors: cancelled; bad_settings: both the drawing and coils.build say how loops are parted.
Result<ArrayBuild> build_array(const Drawing& drawing, const Placement& placement, const SheetSides& sides,
                               const std::optional<BodyBelow>& body, const Settings& settings,
                               const Context& context);

}  // namespace vacuform
