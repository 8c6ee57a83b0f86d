#include "worker/forming/material.hpp"

#include <cstdlib>

namespace vacuform {

MaterialProfile material_profile(Material material) {
  switch (material) {
    case Material::petg:
      return {140, 300};
    case Material::pc:
      return {185, 500};
    case Material::abs:
      return {155, 300};
    case Material::hips:
      return {155, 250};
    case Material::pvc:
      return {135, 300};
  }
  std::abort();
}

double shear_modulus_kpa(Material material, double) { return material_profile(material).shear_modulus_kpa; }

}  // namespace vacuform
