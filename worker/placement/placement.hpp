// Where each element of a drawing lies on the head: the centres on the inked surface, each element in its own
// neighbourhood. worker/coils/coupled_neighbours.hpp handles coupling and decoupling.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "worker/pattern/drawing.hpp"
#include "worker/placement/element_layout.hpp"
#include "worker/placement/segments.hpp"

namespace vacuform {

// One element of the drawing on the surface.
struct PlacedElement {
  int element = 0;                    // index into Drawing::elements
  Eigen::Vector3d centre{0, 0, 0};    // on the inked surface, mm
  Eigen::Vector2d centre_rest{0, 0};  // sheet coordinates, mm
  double moved_mm = 0;                // from where the chart puts the centre, along the surface
  double turned_deg = 0;              // relative to the chart, counter-clockwise seen from outside
  double size = 1;                    // relative to the drawing: 1 except for decoupling and a pattern.scale
  bool on_head = true;                // all of it lies on the chart
  bool smooth = true;                 // false: on bumps, where geodesics from the centre cross
  Patch patch;                        // reaches beyond the element's ink on every side, also off the chart
};

// Two neighbours: loops that touch or overlap in the drawing, or lie next to each other.
struct PlacedPair {
  int a = 0, b = 0;  // indices into Placement::elements, a < b
  double drawn_mm = 0, chart_mm = 0,
         mm = 0;  // distance of the centres: in the drawing; geodesic as the chart puts them, and as placed
  // Coupling of loops before and after decoupling. place() leaves it empty, add_couplings() fills it in.
  std::optional<double> k_before, k;
};

struct Placement {
  // The region of interest, for the parts of the drawing in no element, or for everything: one chart of the whole, or
  // with placement segments several that cover it once. Triangle numbers are those of Flattening::triangles.
  std::vector<Segment> charts;
  std::vector<Seam> seams;              // between the charts, and slits in them
  std::vector<PlacedElement> elements;  // empty when the drawing is laid on one chart
  std::vector<PlacedPair> pairs;
  // The data of the elements (take_layout()): in the same order, and as they lie in flat coordinates.
  ElementLayout layout;
  std::vector<ElementOnSurface> laid;
  double spacing_rms_mm = 0;  // of mm - drawn_mm over the pairs whose coils are both on the head
  std::optional<Warning>
      places_unused;  // "places-unused": places of a layout (CoilPlace) that do not count here
  std::vector<Warning> warnings;
};

// Lays the drawing by settings.pattern and settings.coils. Without a vector drawing, or with placement chart or
// segments, the result has only charts. `cuts`: edges of the sheet, ascending, along which segments are cut
// (with_cut_lines()). Deterministic. Errors: cancelled, unusable_pattern (placement elements without elements).
Result<Placement> place(const ChartedSurface& charted, const Drawing* drawing, const Settings& settings,
                        const Context& context, const std::vector<Edge>& cuts = {});

// The region of interest with sheet coordinates as its pattern coordinates: for a picture of the flat sheet itself.
Placement lay_flat(const ChartedSurface& charted);

// Stores elements that were moved or resized in the placement: its layout, elements, distances of pairs and warnings.
// `scale` is that of the drawing (pattern.scale).
void take_layout(const InkedSurface& surface, const Drawing& drawing, double scale, ElementLayout layout,
                 std::vector<ElementOnSurface> laid, Placement& placement);

// The same elements on the other face of the sheet: at the same points of the sheet, turned alike, and as large there as
// they are drawn. `charted` has the triangles of the surface of `placement`. Pairs and figures are those of the first
// face. Errors: cancelled.
Result<Placement> on_other_face(const ChartedSurface& charted, const Drawing& drawing,
                                const Placement& placement, double scale, const Context& context);

}  // namespace vacuform
