// The drawing pulled back to the flat sheet as vectors: the source of print.svg, print.pdf and print.png if the pattern
// is a vector drawing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/placement/length_errors.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

// An area of one colour, sheet coordinates (s, t), mm, before any mirroring.
struct PaintedArea {
  std::vector<Curve> outlines;
  bool even_odd = false;
  Colour colour;
};

// The middle of a stroke, or of the loop that a coil fills. Unpainted: for plotters,
// dispensers and measuring.
struct Centreline {
  Curve curve;          // sheet coordinates, mm
  double width_mm = 0;  // of the line once formed
};

struct PrintedElement {
  std::string id;                  // of the pattern; empty: in no element
  std::vector<PaintedArea> areas;  // in the order of painting
  std::vector<Centreline> centrelines;
  std::optional<Curve>
      loop;  // of a coil, closed across its gaps; nothing if the print does not contain all of it
};

struct VectorPrint {
  std::vector<PrintedElement>
      elements;  // in the order of painting; elements entirely off their patch have no areas
  // Areas in pattern coordinates, each by the coverage of its ink (white: nothing): all, and those off the patches.
  double painted_mm2 = 0, lost_mm2 = 0;
  std::vector<TiedPoints> tied;  // see below
};

// Strokes become areas in the pattern, with their caps, joins and dashes, and the areas are pulled back, so that every
// line has its drawn width once formed (times settings.pattern.scale; a resized coil keeps its line width). Curves lie
// within 0.02 mm of the exact pull-back. Areas are cut off at the border of their patch and at the border of the page
// of the drawing. If elements are placed, an element that is not placed is lost; without placed elements, all lie on
// the chart.
//
// A line in no element that ends on the ink of an element, or within half its own width of it, is tied to it: the patch
// of the element places its end. Between its ends the line moves from the chart by what it moves at both, gradually more
// like the one or the other; a free end lies on the chart. Deterministic, on any number of threads. Errors: cancelled.
Result<VectorPrint> pull_back(const Drawing& drawing, const Placement& placement, const Settings& settings,
                              const Context& context);

}  // namespace vacuform
