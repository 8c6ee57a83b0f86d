// The drawing pulled back to the flat sheet as vectors: what print.svg, print.pdf and print.png are made of when the
// pattern is one of vectors.
#pragma once

#include <string>
#include <vector>

#include "worker/coils/placement.hpp"

namespace vacuform {

// An area of one colour, sheet coordinates (s, t), mm, before any mirroring.
struct PaintedArea {
  std::vector<Curve> outlines;
  bool even_odd = false;
  Colour colour;
};

// The middle of a stroke. Unpainted: for plotters, dispensers and measuring.
struct Centreline {
  Curve curve;          // sheet coordinates, mm
  double width_mm = 0;  // of the line once formed
};

struct PrintedElement {
  std::string id;                  // of the pattern; empty: in no element
  std::vector<PaintedArea> areas;  // in the order of painting
  std::vector<Centreline> centrelines;
};

struct VectorPrint {
  std::vector<PrintedElement> elements;  // in the order of painting
  double lost_mm2 = 0;                   // painted area, pattern coordinates, that lies off the patches
};

// Strokes become areas in the pattern, with their caps, joins and dashes, and the areas are pulled back, so that every
// line has its drawn width once formed. Curves lie within 0.02 mm of the exact pull-back. What lies off its patch is cut off along the
// patch's border. Lines that join elements begin and end where the elements' own patches put them, and follow the chart
// between. Deterministic. Errors: cancelled.
Result<VectorPrint> pull_back(const Drawing& drawing, const Placement& placement, const Settings& settings,
                              const Context& context);

}  // namespace vacuform
