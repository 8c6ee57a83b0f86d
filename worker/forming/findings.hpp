// What a maker must be told about a formed sheet: where it does not reach the mold, where it shuts in air, where it
// webs, where it is thin, where the mold comes through it.
#pragma once

#include <cmath>
#include <optional>

#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/surface_fit.hpp"
#include "worker/forming/trapped_air.hpp"

namespace vacuform {

// Limits below which nothing is said.
struct FindingLimits {
  double pocket_mm2 = 25;     // of sheet that bridges a hollow of the mold
  double web_mm2 = 25;        // of sheet that is compressed across its tension, in one piece
  FitLimits fit;              // that the mold stands out of the sheet, or that the sheet stays off
  double stretch = HUGE_VAL;  // times: beyond it the law does not describe the plastic
  double stretch_mm2 = 25;    // of sheet that is stretched further, in one piece
  double thickness_ratio = 0.3;
  PocketLimits trapped;
};

// One warning a kind, with the number of places and the worst in its text and up to twenty marks, worst first:
// "not-reached", pieces of free sheet bordered by the mold alone (size: across a disk of their area), then what stays off
// between vertices that touch; "trapped-air", with
// the vents as marks (size: the drill), and in `vents` all of them; "webbing", pieces of slack triangles; "thin", pieces
// of triangles below the limit, each at its thinnest. Places lie on the sheet, in the mold's frame, mm; areas are of the
// formed sheet.
struct Findings {
  std::vector<Warning> warnings;
  std::vector<Vent> vents;
};
Findings forming_findings(const FormedSheet& sheet, const TriangleMesh& mold, double sheet_thickness_mm,
                          const FindingLimits& limits = {});

// Where the sheet is stretched more than twentyfold over more than 25 mm2: no plastic bears that, it is torn, or the
// solution ran away. The largest such place.
struct Tear {
  Eigen::Vector3d place;
  double area_mm2, stretch;
};
std::optional<Tear> torn_at(const FormedSheet& sheet);

}  // namespace vacuform
