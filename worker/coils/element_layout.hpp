// The elements of a drawing while they are being placed, and their loops in space.
#pragma once

#include <vector>

#include "worker/coils/alignment.hpp"
#include "worker/coils/outline.hpp"
#include "worker/coils/polar_grid.hpp"
#include "worker/coils/spacing.hpp"

namespace vacuform {

struct LaidElement {
  int element = 0;  // index into Drawing::elements
  Outline outline;  // at the drawing's scale
  double size = 1;  // of the element, on top of that scale
};

struct ElementLayout {
  std::vector<LaidElement> elements;
  std::vector<Centre> centres;  // of the same elements
  std::vector<Neighbours> pairs;
  std::vector<int> left_out;  // elements of the drawing that are nowhere near the chart
};

// The elements with an id where the chart puts their centres. A centre beyond the chart goes on straight from the chart's
// nearest point; beyond it by more than its element reaches, the element is left out.
ElementLayout lay_by_chart(const InkedSurface& surface, const Drawing& drawing, const Alignment& alignment);

// The grid around one element, wide enough for its ink and a margin; direction 0 is its drawing's u.
PolarGrid grid_around(const InkedSurface& surface, const Centre& centre, const LaidElement& element,
                      double turn);

// The element's loop in space, mm: counter-clockwise, about a hundred points. Empty without a loop, and where a part of
// it would lie beyond the sheet.
std::vector<Eigen::Vector3d> loop_in_space(const PolarGrid& grid, const LaidElement& element);

}  // namespace vacuform
