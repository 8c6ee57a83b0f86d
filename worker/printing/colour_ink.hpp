// The ink that the colours of a scan need on a sheet that stretches, and where there is not enough of it. Internal to
// worker/printing and worker/inspection.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/colour/ink_curve.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/stage/warning.hpp"
#include "worker/surface/inked_surface.hpp"

namespace vacuform {

struct ColourInk {
  InkCurve curve;
  // Formed over flat area of the inked face, over the triangles around each vertex of the sheet. Linear between them, so
  // that the print shows no triangles.
  std::vector<double> area_ratios;

  // What to print so that the stretched sheet shows a colour, as far as full ink can. Red, green and blue in linear
  // light.
  Eigen::Vector3f printed(const Eigen::Vector3f& linear, float area_ratio) const;
  // What the stretched sheet then shows.
  Eigen::Vector3f shown(const Eigen::Vector3f& linear, float area_ratio) const;
  // What the stretched sheet shows of a printed colour.
  Eigen::Vector3f seen(const Eigen::Vector3f& printed, float area_ratio) const;
};
ColourInk colour_ink(const InkedSurface& surface, const InkCurveRows& curve);

// Where full ink cannot show the colours of a scan, because the sheet stretches.
struct InkShortage {
  double coloured_mm2 = 0;  // of the formed inked face
  double short_mm2 = 0;     // of that, where more than 1 % coverage of an ink is missing
  double lack = 0;          // the largest, coverage
  std::size_t ink = 0;      // of which: ink_names
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the largest, mm

  double share() const { return coloured_mm2 > 0 ? short_mm2 / coloured_mm2 : 0; }
};
// Where full ink is not enough for the colours. Examines ten places of each triangle of the sheet. Deterministic for any
// number of threads.
InkShortage ink_shortage(const SheetColours& colours, const InkedSurface& surface, const ColourInk& ink);
// Nothing if it concerns less than 0.1 % of the coloured area.
std::optional<Warning> warning_of(const InkShortage& shortage);

// The colours of a scan, as a layer prints them.
struct PrintedColours {
  const SheetColours& on_sheet;
  std::optional<ColourInk> ink = {};         // what they are compensated with; none: printed as they are
  std::optional<InkShortage> shortage = {};  // where full ink is too little, if they are compensated
};
// Coverages are compensated for the stretch of the sheet if settings.compensate_colours is set.
PrintedColours printed_colours(const SheetColours& colours, const InkedSurface& surface,
                               const PrintSettings& settings);

}  // namespace vacuform
