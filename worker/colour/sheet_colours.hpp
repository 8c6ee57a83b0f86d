// The colours of a scan on the sheet that was formed over it: what the print of pattern.source=scan shows.
#pragma once

#include "worker/colour/coloured_surface.hpp"
#include "worker/colour/hidden_surface.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// How near the formed face must be to the scan.
struct ColourReach {
  double touch_mm = 0.5;  // up to here the colour is full
  double fade_mm = 3;     // from there it fades to nothing over this distance; 0: it ends there

  double end_mm() const { return touch_mm + fade_mm; }
  // The share of the colour at a distance, in [0, 1].
  double share(double distance_mm) const;
};
// `clearance_mm` is what the mold was grown by.
ColourReach colour_reach(double clearance_mm, double fade_mm);

// Areas of the formed sheet, mm2, by the distances of the corners of its triangles.
struct ColouredArea {
  double full_mm2 = 0;  // within touch_mm
  double faded_mm2 =
      0;  // further, but not beyond the end: where the sheet bridges, webs or nears the platform
  // Distance of the sheet from the scan over both, mm.
  double p99_mm = 0;

  double faded_share() const { return faded_mm2 > 0 ? faded_mm2 / (full_mm2 + faded_mm2) : 0; }
};

class SheetColours {
 public:
  // Keeps a reference to the sheet. Searches the scan once for each vertex.
  SheetColours(ColouredSurface surface, const FormedSheet& sheet, const ColourReach& reach);

  const ColouredSurface& surface() const { return surface_; }
  const FormedSheet& sheet() const { return sheet_; }
  const ColourReach& reach() const { return reach_; }
  // Triangles of the sheet that may have colour, ascending.
  const std::vector<int>& triangles() const { return triangles_; }
  const ColouredArea& area() const { return area_; }
  // The triangle of the scan that is nearest to a vertex of the sheet; -1 if none is in reach.
  int nearest_triangle(int vertex) const { return nearest_triangle_[vertex]; }
  // The parts of the scan whose colour the sheet does not show.
  const HiddenSurface& hidden() const { return hidden_; }

 private:
  ColouredSurface surface_;
  const FormedSheet& sheet_;
  ColourReach reach_;
  std::vector<int> triangles_, nearest_triangle_;
  ColouredArea area_;
  HiddenSurface hidden_;
};

}  // namespace vacuform
