// The plastics: what heating and forming need to know of each.
#pragma once

#include "api/settings.hpp"

namespace vacuform {

// Williams-Landel-Ferry: the viscosity at `celsius` is that at `reference_celsius` times
// exp(-a1 (celsius - reference) / (a2 + celsius - reference)). Natural logarithm, as in the Cross-WLF tables of
// injection moulding; the first constant of WLF's own decimal form is a1 / ln 10.
struct WilliamsLandelFerry {
  double reference_celsius;
  double a1;         // 1
  double a2_kelvin;  // K
};

struct MaterialProfile {
  double glass_celsius;    // glass transition
  double coldest_celsius;  // the forming window: colder sheet tears or does not follow the mold,
  double hottest_celsius;  // hotter sheet sags, blisters or tears
  double density_kg_m3;
  double heat_capacity_j_kgk;  // mean from room to forming temperature
  double conductivity_w_mk;
  double emissivity;          // of the rays of heaters, 2 to 10 um, what passes a face (1 - reflectance)
  double absorption_1_mm;     // in depth (Beer-Lambert), mean over the radiation of a hot heater
  double viscosity_pa_s;      // shear viscosity in the middle of the forming window
  WilliamsLandelFerry shift;  // and how it changes with temperature
  double plateau_kpa;         // shear modulus of the sheet where it is rubber and does not yet flow

  double forming_celsius() const { return (coldest_celsius + hottest_celsius) / 2; }
};

MaterialProfile material_profile(Material material);

// Shear viscosity of the hot sheet. Strictly falling; beyond 5 degrees above the glass transition on the one side and
// 60 degrees above the forming window on the other it keeps its last value.
double viscosity_pa_s(Material material, double celsius);

// Small-strain shear modulus of the hot sheet over the second that forming takes: that of a rubber that flows in
// series (a Maxwell body under constant stress), 1 / (1 / plateau + seconds / viscosity). Limited as the viscosity.
double shear_modulus_kpa(Material material, double celsius);

}  // namespace vacuform
