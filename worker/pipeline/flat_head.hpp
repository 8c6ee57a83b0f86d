// The head of a print: formed, flattened and cut, with the colours of its scan.
#pragma once

#include <optional>
#include <vector>

#include "worker/colour/sheet_colours.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/pipeline/formed_head.hpp"
#include "worker/placement/chart_pieces.hpp"
#include "worker/surface/inked_surface.hpp"

namespace vacuform {

struct FlatHead {
  FormedHead formed;
  InkedSurface surface;
  Flattening flattening;
  std::vector<Edge> cuts;               // edges of the sheet along which segments are cut
  std::optional<ColouredScan> colours;  // if they are printed
};

// `coverage`: see flatten(). Errors: those of the stages.
Result<FlatHead> flat_head(const Inputs& inputs, const InkCoverage& coverage, const Context& context);

// The colours of the scan where the sheet comes to lie on it, if they are printed. They are moved from the head, and keep
// a reference to its sheet. Errors: unusable_surface (the sheet is nowhere near the scan).
Result<std::optional<SheetColours>> colours_on_sheet(FlatHead& head, const Inputs& inputs);

}  // namespace vacuform
