// The elements of a drawing while they are being placed, and their loops in space.
#pragma once

#include <optional>
#include <vector>

#include "worker/placement/alignment.hpp"
#include "worker/placement/element_patch.hpp"
#include "worker/placement/outline.hpp"
#include "worker/placement/spacing.hpp"

namespace vacuform {

struct LaidElement {
  int element = 0;  // index into Drawing::elements
  Outline outline;  // at the drawing's scale
  double size = 1;  // of the element, in addition to that scale
  // Whose neighbourhood it lies in, as an index into the layout's elements: that of the coil about which it lies, or of
  // the nearest coil for what is no coil; -1: it has a place of its own.
  int leader = -1;
};

struct ElementLayout {
  std::vector<LaidElement> elements;
  std::vector<Centre> centres;  // of the same elements
  std::vector<Neighbours> pairs;
  std::optional<Centre> origin;  // the centre of the drawing, if it lies on the chart
  std::vector<int> left_out;     // elements of the drawing that are far from the chart
  CoilKeep keep = CoilKeep::area;
};

// The elements with an id at the places that the chart gives their centres. A centre beyond the chart continues
// straight from the nearest point of the chart. If it is beyond the chart by more than the reach of its element, the
// element is left out. A coil about the same centre as another, and what is no coil, follows a leader.
ElementLayout lay_by_chart(const ChartedSurface& charted, const Drawing& drawing, const Alignment& alignment);

// Moves what follows a leader to its drawn distance and direction from it, along the surface.
void follow_leaders(const ChartedSurface& charted, ElementLayout& layout);

// An element once it lies on the surface.
struct ElementOnSurface {
  double turn = 0;  // rotation of the axis of its centre, radians (spacing.hpp)
  ElementPatch patch;
  bool on_head = true;                // all of its curves lie on the chart
  std::vector<Eigen::Vector3d> loop;  // in space, mm; empty without a loop, or if it runs off the sheet
};

// The elements of a layout at the current places of their centres; `rough` as in element_patch(). Errors: cancelled.
Result<std::vector<ElementOnSurface>> lay_on_surface(const ChartedSurface& charted,
                                                     const ElementLayout& layout, const Context& context,
                                                     bool rough = false);

// The same with rotations that are known, one an element.
Result<std::vector<ElementOnSurface>> lay_turned(const ChartedSurface& charted, const ElementLayout& layout,
                                                 const std::vector<double>& turn, const Context& context,
                                                 bool rough = false);

// The loop of the element in space by flat coordinates, mm; empty if a part of it lies beyond the map. PolarGrid and
// ElementMap are such maps.
template <class Map>
std::vector<Eigen::Vector3d> loop_in_space(const Map& map, const LaidElement& element) {
  std::vector<Eigen::Vector3d> out;
  for (const Eigen::Vector2d& p : element.outline.loop) {
    const auto place = map.place(element.size * p);
    if (!place) return {};
    out.push_back(*place);
  }
  return out;
}

}  // namespace vacuform
