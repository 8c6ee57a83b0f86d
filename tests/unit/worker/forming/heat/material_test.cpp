// The plastics against measured ratios.
#include <gtest/gtest.h>

#include "worker/forming/material.hpp"

namespace vacuform {
namespace {

constexpr std::array plastics{Material::petg, Material::pc, Material::abs, Material::hips, Material::pvc};

// Ten degrees in the middle of the forming window change the viscosity of ABS 2.5 to 2.9 times, of PC 6 to 9 times.
TEST(Plastics, ViscosityFollowsTheTemperature) {
  const auto ten_degrees = [](Material m) {
    const double middle = material_profile(m).forming_celsius();
    return viscosity_pa_s(m, middle - 5) / viscosity_pa_s(m, middle + 5);
  };
  EXPECT_GE(ten_degrees(Material::abs), 2.5);
  EXPECT_LE(ten_degrees(Material::abs), 2.9);
  EXPECT_GE(ten_degrees(Material::pc), 6);
  EXPECT_LE(ten_degrees(Material::pc), 9);
}

TEST(Plastics, TenDegreesColderIsAboutThreeTimesStiffer) {
  for (const Material m : plastics) {
    const double middle = material_profile(m).forming_celsius();
    const double stiffer = shear_modulus_kpa(m, middle - 10) / shear_modulus_kpa(m, middle);
    EXPECT_GT(stiffer, 2.4) << name(m);
    EXPECT_LT(stiffer, 3.8) << name(m);
    EXPECT_GT(shear_modulus_kpa(m, middle), 100) << name(m);
    EXPECT_LT(shear_modulus_kpa(m, middle), 1000) << name(m);
  }
}

TEST(Plastics, HotterIsSofterAndNothingIsInfinite) {
  for (const Material m : plastics) {
    const MaterialProfile p = material_profile(m);
    EXPECT_LT(p.glass_celsius, p.coldest_celsius);
    EXPECT_LT(p.coldest_celsius, p.hottest_celsius);
    for (double c = p.glass_celsius + 5; c < p.hottest_celsius + 59; c += 1) {
      EXPECT_GT(viscosity_pa_s(m, c), viscosity_pa_s(m, c + 1)) << name(m) << c;
      EXPECT_GT(shear_modulus_kpa(m, c), shear_modulus_kpa(m, c + 1)) << name(m) << c;
    }
    EXPECT_EQ(viscosity_pa_s(m, -200), viscosity_pa_s(m, p.glass_celsius + 5));
    EXPECT_EQ(shear_modulus_kpa(m, 2000), shear_modulus_kpa(m, p.hottest_celsius + 60));
    EXPECT_LT(shear_modulus_kpa(m, -200), p.plateau_kpa);
    EXPECT_GT(shear_modulus_kpa(m, 2000), 0.1);
  }
}

}  // namespace
}  // namespace vacuform
