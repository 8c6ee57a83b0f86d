// The flattening stage: the formed sheet in, pattern coordinates on its region of interest out.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "api/settings.hpp"
#include "worker/context.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// One chart: the largest connected part of the sheet that lies on the mold, with its inner holes filled.
// Chart coordinates are millimetres on the inked surface, true to scale; their origin is the top of the mold, and
// they are turned as little as possible against the sheet's axes. v is up. Seen from the inked face's outer side
// (the side that faces the ceiling), whichever face carries the ink.
struct Flattening {
  std::vector<int> triangles;          // of the chart: indices into FormedSheet::triangles, ascending
  std::vector<Eigen::Vector2d> chart;  // per vertex of the sheet; NaN off the chart
  std::vector<Eigen::Vector3d> inked;  // per vertex of the sheet: the surface that carries the ink, mm
  Eigen::Vector2d top_rest;            // sheet coordinates of the top of the mold (the chart's origin)
  int iterations = 0;
  double energy = 0;  // ARAP energy per area of the chart, dimensionless
  int flipped = 0;    // triangles turned over by the flattening (0 in a good chart)
  std::vector<Warning> warnings;
};

// Pure and deterministic. Errors: unusable_surface, cancelled.
Result<Flattening> flatten(const FormedSheet& sheet, const Mold& mold, const FlatteningSettings& settings,
                           InkedFace inked_face, const Context& context);

}  // namespace vacuform
