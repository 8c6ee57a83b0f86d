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

// Flat coordinates (element_patch.hpp) to space: PolarGrid and PatchMap both do.
template <class Map>
std::vector<Eigen::Vector3d> loop_in_space(const Map& map, const LaidElement& element) {
  std::vector<Eigen::Vector3d> out;
  for (const Eigen::Vector2d& p : element.outline.loop) {
    const auto place = map.place(element.size * p);
    if (!place) return {};  // a part of it lies beyond the sheet
    out.push_back(*place);
  }
  return out;
}

}  // namespace vacuform
