// The drawing pulled back to the flat sheet as vectors: what print.svg, print.pdf and print.png are made of when the
// pattern is one of vectors.
#pragma once

#include <string>
#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

// An area of one colour, sheet coordinates (s, t), mm, before any mirroring.
struct PaintedArea {
  std::vector<Curve> outlines;
  bool even_odd = false;
  Colour colour;
};

// The middle of a stroke, or of a ring that an element fills (coils/drawn_loop.hpp). Unpainted: for plotters, dispensers
// and measuring.
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
  std::vector<PrintedElement>
      elements;  // in the order of painting; what lies off its patch altogether has no areas
  // Areas in pattern coordinates, each by the coverage of its ink (white: nothing): all, and what lies off the patches.
  double painted_mm2 = 0, lost_mm2 = 0;
};

// Strokes become areas in the pattern, with their caps, joins and dashes, and the areas are pulled back, so that every
// line has its drawn width once formed (times settings.pattern.scale; a coil that was resized keeps it). Curves lie within
// 0.02 mm of the exact pull-back. What lies off its patch is cut off along the patch's border, what sticks out of the
// drawing's page along the page's. Where elements are placed, one that is not is lost; without any, all lie on the chart.
//
// A line that belongs to no element and ends on an element's ink, or within half its own width of it, is tied to it: its
// end lies where the element's patch puts it, and along the first 20 mm, or half its length, the line passes over to the
// chart. Deterministic, on any number of threads. Errors: cancelled.
Result<VectorPrint> pull_back(const Drawing& drawing, const Placement& placement, const Settings& settings,
                              const Context& context);

}  // namespace vacuform
