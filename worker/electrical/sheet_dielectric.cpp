#include "worker/electrical/sheet_dielectric.hpp"

#include <cmath>

namespace vacuform {

namespace {

constexpr double vacuum_pf_per_mm = 8.8541878e-3;

// PETG and ABS: Picha, Papezova and Picha, Processes 10 (2022) 1881, printed samples at 1 to 100 MHz: 2.88 to 3.48 and .03 to
// 4.3 %, with much spread by colour. PC, HIPS and PVC: tables of makers at 1 to 10 MHz, 2.9 and 1 %, 2.5 and .05 to .2 %, 2.8
// to 3.4 and about 1 %. A sheet is to be measured before its capacitors are printed.
Dielectric of_material(Material material) {
  switch (material) {
    case Material::petg:
      return {3.0, 0.02};
    case Material::pc:
    case Material::abs:
      return {2.9, 0.01};
    case Material::hips:
      return {2.5, 0.001};
    case Material::pvc:
      return {3.0, 0.01};
  }
  return {};
}

}  // namespace

Dielectric sheet_dielectric(const SheetSettings& sheet) {
  const Dielectric usual = of_material(sheet.material);
  return {sheet.permittivity.value_or(usual.permittivity), sheet.loss_tangent.value_or(usual.loss_tangent)};
}

double plate_pf_per_mm(double width_mm, double thickness_mm, double permittivity) {
  return vacuum_pf_per_mm * permittivity * width_mm / thickness_mm;
}

double plate_pf_per_mm_with_edges(double width_mm, double thickness_mm, double permittivity) {
  const double ratio = width_mm / thickness_mm;
  const double effective = (permittivity + 1) / 2 + (permittivity - 1) / 2 / std::sqrt(1 + 12 / ratio);
  if (ratio < 1) return vacuum_pf_per_mm * effective * 2 * M_PI / std::log(8 / ratio + ratio / 4);
  return vacuum_pf_per_mm * effective * (ratio + 1.393 + 0.667 * std::log(ratio + 1.444));
}

}  // namespace vacuform
