// The plastics: what forming needs to know of each.
#pragma once

#include "api/settings.hpp"

namespace vacuform {

struct MaterialProfile {
  double forming_celsius;    // middle of the forming window
  double shear_modulus_kpa;  // small-strain modulus of the rubbery sheet at that temperature
};

// Forming windows: Throne, Technology of Thermoforming (1996), as in the material makers' guides. The moduli are the
// order of magnitude of hot rubbery sheet (0.1 to 1 MPa): a uniform modulus does not move the print, it only sets
// how sharply the vacuum presses the sheet into corners.
MaterialProfile material_profile(Material material);

double shear_modulus_kpa(Material material, double celsius);

}  // namespace vacuform
