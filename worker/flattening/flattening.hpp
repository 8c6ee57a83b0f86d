// The flattening stage: the formed sheet in, pattern coordinates on its region of interest out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "api/settings.hpp"
#include "worker/flattening/weights.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/stage/context.hpp"
#include "worker/surface/inked_surface.hpp"

namespace vacuform {

// One chart: the largest connected part of the sheet that lies on the mold, with its inner holes filled.
// Chart coordinates are millimetres on the inked surface, true to scale; their origin is the top of the mold, and
// they are turned as little as possible against the sheet's axes. v is up. Seen from the inked face's outer side
// (the side that faces the ceiling), whichever face carries the ink.
//
// Pins say otherwise: a row (s, t, u, v) of settings.flattening.pins lays the point (s, t) of the flat sheet at (u, v) of
// the chart. One pin shifts the chart as it would lie without; then the origin is no longer the top of the mold, but
// wherever the pin puts it. Two and more also turn it, and where their distances are not those on the inked surface, they
// distort it: arap, symmetric_dirichlet and lscm bend the chart to them, cgal_arap and bfs are only moved as near as a
// rigid motion can. "pins-not-met" is a warning when a pin ends further than 0.1 mm from its place.
struct Flattening {
  std::vector<int> triangles;          // of the chart: indices into FormedSheet::triangles, ascending
  std::vector<Eigen::Vector2d> chart;  // per vertex of the sheet; NaN off the chart
  Eigen::Vector2d top_rest;  // sheet coordinates of the top of the mold (the chart's origin without pins)
  int iterations = 0;        // of the method, all rounds
  double energy = 0;         // ARAP energy per area of the chart, dimensionless, whatever the method
  double symmetric_dirichlet = 4;  // the same of that energy: 4 without distortion; infinite with a flip
  int flipped = 0;                 // triangles turned over by the flattening (0 in a good chart)
  int crossings = 0;  // of the chart's border with itself: above 0 the chart covers a place twice

  // Where the settings favour a part of the chart: what its triangles count (parallel to `triangles`; empty without),
  // and which of them are the part: those that count at least half as much more as any can.
  std::vector<double> weight;
  std::vector<std::uint8_t> favoured;
  double energy_favoured = 0, energy_rest = 0;  // `energy` of either

  std::vector<Warning>
      warnings;  // flattening-not-converged, -flipped, -overlaps; top-off-chart, pins-not-met
};

// Pure and deterministic. `surface` is the inked surface of the sheet. `coverage` tells where the drawing has ink when settings.weights is ink, and how dark the painted
// map is when it is painted, and must be given then: the chart is flattened evenly first, and twice again with its place on
// the chart before. cgal_arap and bfs know no weights. Errors: unusable_surface, bad_settings (a pin that is not on the
// chart), cancelled.
Result<Flattening> flatten(const FormedSheet& sheet, const InkedSurface& surface, const Mold& mold,
                           const FlatteningSettings& settings, const Context& context,
                           const InkCoverage& coverage = {});

}  // namespace vacuform
