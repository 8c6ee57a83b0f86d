// What a maker must be told about a formed sheet: where it does not reach the mold, where it webs, where it is thin.
#pragma once

#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// Limits below which nothing is said.
struct FindingLimits {
  double pocket_mm2 = 25;  // of sheet that bridges a hollow of the mold
  double web_mm2 = 25;     // of sheet that is compressed across its tension, in one piece
  double thickness_ratio = 0.3;
};

// "not-reached": pieces of free sheet bordered by the mold alone; "webbing": pieces of slack triangles; "thin": the
// thinnest element. One warning a kind, with the number of places, and place and size of the worst. Places are in the
// mold's frame, mm; areas are of the formed sheet, mm^2.
std::vector<Warning> forming_findings(const FormedSheet& sheet, double sheet_thickness_mm,
                                      const FindingLimits& limits = {});

}  // namespace vacuform
