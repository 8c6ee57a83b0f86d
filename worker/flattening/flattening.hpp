// The flattening stage: takes the formed sheet and gives pattern coordinates on its region of interest.
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
// Chart coordinates are millimetres on the inked surface, true to scale. Their origin is the top of the mold. They are
// rotated as little as possible against the axes of the sheet. v is up. The view is from the outer side of the inked
// face (the side that faces the ceiling), whichever face carries the ink.
//
// Pins change this: a row (s, t, u, v) of settings.flattening.pins lays the point (s, t) of the flat sheet at (u, v) of
// the chart. One pin only shifts the chart; the origin is then where the pin puts it, not the top of the mold. Two or
// more pins also rotate it. If their distances differ from those on the inked surface, they distort it: arap,
// symmetric_dirichlet and lscm bend the chart to them, cgal_arap and bfs only move it as near as a rigid motion can.
// "pins-not-met" is a warning if a pin ends further than 0.1 mm from its place.
struct Flattening {
  std::vector<int> triangles;          // of the chart: indices into FormedSheet::triangles, ascending
  std::vector<Eigen::Vector2d> chart;  // per vertex of the sheet; NaN off the chart
  Eigen::Vector2d top_rest;  // sheet coordinates of the top of the mold (the chart's origin without pins)
  int iterations = 0;        // of the method, all rounds
  double energy = 0;         // ARAP energy per area of the chart, dimensionless, for every method
  double symmetric_dirichlet = 4;  // the same for that energy: 4 without distortion; infinite with a flip
  int flipped = 0;                 // triangles turned over by the flattening (0 in a good chart)
  int crossings = 0;  // of the border of the chart with itself: above 0 the chart covers a place twice

  // If the settings favour a part of the chart: the weights of its triangles (parallel to `triangles`; empty
  // otherwise), and the triangles of that part: those whose extra weight is at least half of the maximum.
  std::vector<double> weight;
  std::vector<std::uint8_t> favoured;
  double energy_favoured = 0, energy_rest = 0;  // `energy` of each part

  std::vector<Warning>
      warnings;  // flattening-not-converged, -flipped, -overlaps; top-off-chart, pins-not-met
};

// Pure and deterministic. `surface` is the inked surface of the sheet. `coverage` says where the drawing has ink if
// settings.weights is ink, and how dark the weight image is if it is painted. It is required in these cases: the chart
// is first flattened evenly, then twice more with its previous place on the chart. cgal_arap and bfs ignore weights.
// Errors: unusable_surface, bad_settings (a pin that is not on the chart), cancelled.
Result<Flattening> flatten(const FormedSheet& sheet, const InkedSurface& surface, const Mold& mold,
                           const FlatteningSettings& settings, const Context& context,
                           const InkCoverage& coverage = {});

}  // namespace vacuform
