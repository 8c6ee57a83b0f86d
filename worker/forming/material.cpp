#include "worker/forming/material.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vacuform {

namespace {

constexpr double forming_seconds = 1;

}  // namespace

MaterialProfile material_profile(Material material) {
  switch (material) {
    case Material::petg:
      return {80, 121, 160, 1270, 1250, 0.20, 0.94, 2, 3.3e5, {80, 28.0, 51.6}, 3100};
    case Material::pc:
      return {149, 170, 200, 1200, 1200, 0.20, 0.94, 2, 6.5e5, {149, 29.6, 51.6}, 2200};
    case Material::abs:
      return {105, 127, 182, 1040, 1300, 0.20, 0.94, 4, 3.4e5, {105, 20.0, 51.6}, 3000};
    case Material::hips:
      return {100, 130, 180, 1050, 1300, 0.15, 0.94, 4, 2.8e5, {100, 25.74, 61.06}, 3000};
    case Material::pvc:
      return {80, 110, 160, 1400, 900, 0.16, 0.94, 2, 3.4e5, {80, 25.0, 51.6}, 2500};
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
