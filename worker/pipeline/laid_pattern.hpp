// The pattern of a print on the head, and the layers that print it.
#pragma once

#include <optional>
#include <vector>

#include "worker/colour/sheet_colours.hpp"
#include "worker/conductors/array_build.hpp"
#include "worker/pattern/ink_parts.hpp"
#include "worker/pipeline/flat_head.hpp"
#include "worker/placement/alignment.hpp"
#include "worker/printing/layer.hpp"

namespace vacuform {

// What the top layer of the print shows, and how it lies on the head.
struct LaidPattern {
  Pattern pattern;
  std::optional<Drawing> lines = {};   // of a vector drawing
  std::optional<InkParts> parts = {};  // of a picture whose parts are placed one by one
  Placement placement = {};
  std::optional<ArrayBuild> build = {};  // of a vector drawing with loops or layers
  Alignment alignment = {};              // on the flat sheet, as drawn
  std::vector<Warning> warnings = {};    // of the drawing and of the placement

  // What was placed element by element; null: nothing, the pattern lies on the chart.
  const Drawing* placed() const { return lines ? &*lines : parts ? &parts->drawing() : nullptr; }
};

// The pattern of the inputs, as it was read. `reverse` is the other face, `body` loads the loops, `cuts` are those of the
// head. Errors: those of the
// stages; unusable_pattern where settings.coils asks for a build and there are no loops to build.
Result<LaidPattern> lay_pattern(Pattern pattern, const Inputs& inputs, const ChartedSurface& charted,
                                const ChartedSurface& reverse, const std::optional<BodyBelow>& body,
                                const std::vector<Edge>& cuts, const Context& context);

// The colours of a scan as the pattern. It has the coordinates of the sheet, and nothing is bent. Errors: cancelled.
Result<LaidPattern> lay_colours(const SheetColours& colours, const ChartedSurface& charted,
                                const SheetSettings& sheet, const Context& context);

// The layers that the settings ask for: the pattern, the colours of the scan, or the one over the other. They keep
// references to all that they are made of. Errors: cancelled.
Result<std::vector<Layer>> layers_of(const LaidPattern& laid, const std::optional<SheetColours>& colours,
                                     const InkedSurface& surface, const Settings& settings,
                                     const Context& context);

}  // namespace vacuform
