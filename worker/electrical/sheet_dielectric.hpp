// The sheet as the dielectric of capacitors that are printed on both of its faces.
#pragma once

#include "api/settings.hpp"

namespace vacuform {

struct Dielectric {
  double permittivity = 1;  // relative
  double loss_tangent = 0;
};

// As the settings say, or else of the material at 1 to 100 MHz.
Dielectric sheet_dielectric(const SheetSettings& sheet);

// Of a plate over a wider one, pF for each millimetre of its length: of the field between the two alone, and with that at the
// edges of the plate, within a percent (Hammerstad, Equations for Microstrip Circuit Design, 1975).
double plate_pf_per_mm(double width_mm, double thickness_mm, double permittivity);
double plate_pf_per_mm_with_edges(double width_mm, double thickness_mm, double permittivity);

}  // namespace vacuform
