// Warnings about a formed sheet: where it does not reach the mold, where it traps air, where it webs, where it is thin,
// where the mold comes through it.
#pragma once

#include <cmath>
#include <optional>

#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/surface_fit.hpp"
#include "worker/forming/trapped_air.hpp"

namespace vacuform {

// Limits below which there is no warning.
struct FindingLimits {
  double pocket_mm2 = 25;     // of sheet that bridges a hollow of the mold
  bool rough = false;         // the mold: sheet that lies upside down on it is folded over a grain
  double web_mm2 = 25;        // of sheet that is compressed across its tension, in one piece
  FitLimits fit;              // that the mold stands out of the sheet, or that the sheet stays off
  double stretch = HUGE_VAL;  // times: above this the material law does not describe the plastic
  double stretch_mm2 = 25;    // of sheet that is stretched further, in one piece
  double thickness_ratio = 0.3;
  PocketLimits trapped;
};

// One warning per kind, with the number of places and the worst in its text and up to twenty marks, worst first:
// "not-reached", pieces of free sheet bordered by the mold alone (size: diameter of a disk of their area), then gaps
// between vertices that touch; "trapped-air", with the vents as marks (size: the drill), and all of them in `vents`;
// "webbing", pieces of triangles that are wrinkled or hang over; "thin", pieces of triangles below the limit, each at its
// thinnest point. Places lie on the sheet, in the frame of the mold, mm; areas are of the formed sheet.
struct Findings {
  std::vector<Warning> warnings;
  std::vector<Vent> vents;
};
Findings forming_findings(const FormedSheet& sheet, const TriangleMesh& mold, double sheet_thickness_mm,
                          const FindingLimits& limits = {});

// Where the sheet is stretched more than tenfold over more than 25 mm2. No plastic survives that: the sheet is torn,
// or the solution diverged. Returns the largest such place.
struct Tear {
  Eigen::Vector3d place;
  double area_mm2, stretch;
};
std::optional<Tear> torn_at(const FormedSheet& sheet);

}  // namespace vacuform
