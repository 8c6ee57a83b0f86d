#include "worker/forming/material.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vacuform {

namespace {

constexpr double forming_seconds = 1;

}  // namespace

// Sources. Density, heat capacity, conductivity, glass transition and forming window: Throne, Technology of
// Thermoforming (Hanser 1996), and the guides of sheet makers. Plastics reflect 4 to 10 % of infrared radiation, which
// gives 0.94. Absorption: Throne, Thermal Radiant Absorption in Thin Semitransparent Plastics: clear sheet of 0.25 mm
// absorbs 40 to 60 % of the heater radiation, which is 2 to 3.7 per millimetre; twice as much where pigment and rubber
// scatter.
//
// Shift: a2 is the universal constant 51.6 K of Williams, Landel and Ferry (J. Am. Chem. Soc. 77, 1955); for styrene it
// is that of BASF's Polystyrol 678 E as openInjMoldSim uses it (a1 25.74, a2 61.06 K at 100 C). Published Cross-WLF
// fits have a1 from 20 to 36 with it. Within that range, ABS is set so that ten degrees in the middle of its window
// change the viscosity 2.7 times (measured: 2.5 to 2.9), PC 7.3 times (6 to 9). The viscosity itself is set so that the
// modulus in the middle of the window is 230 to 510 kPa: the modulus of hot sheet is 0.1 to 1 MPa (Throne). The
// viscosity does not move the print; only its variation over the sheet does.
//
// Plateau: Fetters, Lohse, Richter, Witten and Zirkel, Macromolecules 27 (1994): PET 3.1 MPa, PC 2.7 MPa. For ABS, HIPS
// and PVC the entanglements alone would give less, rubber and crystallites more; 3 MPa is used for all of them. It only
// limits the stiffness of sheet that is too cold to be formed.
MaterialProfile material_profile(Material material) {
  switch (material) {
    case Material::petg:
      return {.glass_celsius = 80,
              .coldest_celsius = 121,
              .hottest_celsius = 160,
              .density_kg_m3 = 1270,
              .heat_capacity_j_kgk = 1250,
              .conductivity_w_mk = 0.20,
              .emissivity = 0.94,
              .absorption_1_mm = 3,
              .viscosity_pa_s = 3.3e5,
              .shift = {80, 28, 51.6},
              .plateau_kpa = 3100};
    case Material::pc:
      return {.glass_celsius = 149,
              .coldest_celsius = 170,
              .hottest_celsius = 200,
              .density_kg_m3 = 1200,
              .heat_capacity_j_kgk = 1200,
              .conductivity_w_mk = 0.20,
              .emissivity = 0.94,
              .absorption_1_mm = 3,
              .viscosity_pa_s = 6.2e5,
              .shift = {149, 29.6, 51.6},
              .plateau_kpa = 2700};
    case Material::abs:
      return {.glass_celsius = 105,
              .coldest_celsius = 127,
              .hottest_celsius = 182,
              .density_kg_m3 = 1040,
              .heat_capacity_j_kgk = 1300,
              .conductivity_w_mk = 0.20,
              .emissivity = 0.94,
              .absorption_1_mm = 6,
              .viscosity_pa_s = 3.4e5,
              .shift = {105, 20, 51.6},
              .plateau_kpa = 3000};
    case Material::hips:
      return {.glass_celsius = 100,
              .coldest_celsius = 130,
              .hottest_celsius = 180,
              .density_kg_m3 = 1050,
              .heat_capacity_j_kgk = 1300,
              .conductivity_w_mk = 0.15,
              .emissivity = 0.94,
              .absorption_1_mm = 6,
              .viscosity_pa_s = 2.5e5,
              .shift = {100, 25.74, 61.06},
              .plateau_kpa = 3000};
    case Material::pvc:
      return {.glass_celsius = 80,
              .coldest_celsius = 110,
              .hottest_celsius = 160,
              .density_kg_m3 = 1400,
              .heat_capacity_j_kgk = 900,
              .conductivity_w_mk = 0.16,
              .emissivity = 0.94,
              .absorption_1_mm = 3,
              .viscosity_pa_s = 3.4e5,
              .shift = {80, 25, 51.6},
              .plateau_kpa = 3000};
  }
  std::abort();
}

double viscosity_pa_s(Material material, double celsius) {
  const MaterialProfile m = material_profile(material);
  const auto exponent = [&](double at) {
    const double above = at - m.shift.reference_celsius;
    return -m.shift.a1 * above / (m.shift.a2_kelvin + above);
  };
  const double warm = std::clamp(celsius, m.glass_celsius + 5, m.hottest_celsius + 60);
  return m.viscosity_pa_s * std::exp(exponent(warm) - exponent(m.forming_celsius()));
}

double shear_modulus_kpa(Material material, double celsius) {
  const double flow_kpa = viscosity_pa_s(material, celsius) / forming_seconds / 1000;
  return 1 / (1 / material_profile(material).plateau_kpa + 1 / flow_kpa);
}

}  // namespace vacuform
