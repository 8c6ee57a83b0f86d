// Heat: view factors, rays between reflectors, the slab, and the plastics against PHYSICS' exact cases.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "worker/forming/heat/irradiance.hpp"
#include "worker/forming/heat/slab.hpp"
#include "worker/forming/heat/view_factor.hpp"
#include "worker/forming/material.hpp"

namespace vacuform {
namespace {

TEST(ViewFactor, OfCornersAndCentredSquares) {
  EXPECT_NEAR(view_factor(0, 1, 0, 1, 1), 0.138532, 1e-6);
  EXPECT_NEAR(view_factor(-1, 1, -1, 1, 1), 0.554126, 1e-6);
  EXPECT_NEAR(view_factor(-100, 100, -100, 100, 100), 0.554126, 1e-6);
  EXPECT_NEAR(view_factor(-1e9, 1e9, -1e9, 1e9, 1), 1, 1e-8);
}

// Anywhere: the parts of a rectangle add up to it, and a small one is cos^2 / (pi r^2) of its area.
TEST(ViewFactor, OfRectanglesAnywhere) {
  const double whole = view_factor(30, 90, -20, 50, 40);
  EXPECT_NEAR(view_factor(30, 70, -20, 50, 40) + view_factor(70, 90, -20, 50, 40), whole, 1e-15);
  EXPECT_NEAR(view_factor(-90, -30, -20, 50, 40), whole, 1e-15);
  const double x = 30, y = -50, h = 40, r2 = x * x + y * y + h * h;
  EXPECT_NEAR(
      view_factor(x - 0.05, x + 0.05, y - 0.05, y + 0.05, h) / (0.01 * h * h / (std::numbers::pi * r2 * r2)),
      1, 1e-5);
}

Heater heater(double x, double y, double width, double height, double z, double celsius) {
  Heater h;
  h.x_mm = x, h.y_mm = y, h.z_mm = z, h.width_mm = width, h.height_mm = height, h.celsius = celsius;
  return h;
}

double black(double celsius) { return stefan_boltzmann * std::pow(celsius + 273.15, 4); }

TEST(Irradiance, SumsExactViewFactorsOfEachSide) {
  MachineSettings machine;
  machine.heaters = {heater(0, 0, 200, 200, 100, 500), heater(50, 0, 100, 100, -200, 400)};
  machine.heaters[1].emissivity = 0.5;
  HeatSettings heat;
  const Irradiance above(machine, heat, Irradiance::Side::above);
  const Irradiance below(machine, heat, Irradiance::Side::below);
  EXPECT_NEAR(above.above_surroundings({0, 0}), 0.9 * 0.5541264 * (black(500) - black(23)), 0.01);
  EXPECT_NEAR(below.above_surroundings({50, 0}),
              0.5 * view_factor(-50, 50, -50, 50, 200) * (black(400) - black(23)), 1e-9);
}

TEST(Irradiance, OfPowerAndGain) {
  MachineSettings machine;
  machine.heaters = {heater(0, 0, 200, 100, 100, 0)};
  machine.heaters[0].celsius.reset();
  machine.heaters[0].power_w = 400;  // 20 kW/m2
  machine.heaters[0].zone = "middle";
  HeatSettings heat;
  heat.gains["middle"] = 0.5;
  EXPECT_NEAR(Irradiance(machine, heat, Irradiance::Side::above).above_surroundings({0, 0}),
              10000 * view_factor(-100, 100, -50, 50, 100), 1e-9);
}

// A flat 300 x 450 panel gives the corners of a sheet of its own size only 0.36 to 0.44 of the centre.
TEST(Irradiance, OfAPanelAtTheCornersOfTheSheet) {
  HeatSettings heat;
  for (const auto& [z, share] : {std::pair(75.0, 0.36), std::pair(200.0, 0.44)}) {
    MachineSettings machine;
    machine.heaters = {heater(0, 0, 300, 450, z, 500)};
    const Irradiance panel(machine, heat, Irradiance::Side::above);
    EXPECT_NEAR(panel.above_surroundings({150, 225}) / panel.above_surroundings({0, 0}), share, 0.1) << z;
  }
}

// Mirrors from the heater down to the sheet: an endless field of images, each weaker by the reflectance.
double by_images(double x, double y, double side, double z, double reflectance) {
  double sum = 0;
  for (int i = -40; i <= 40; ++i)
    for (int j = -40; j <= 40; ++j)
      sum += std::pow(reflectance, std::abs(i) + std::abs(j)) *
             view_factor((i - 0.5) * side - x, (i + 0.5) * side - x, (j - 0.5) * side - y,
                         (j + 0.5) * side - y, z);
  return sum;
}

TEST(Irradiance, ReflectorsMakeTheImagesOfTheHeater) {
  MachineSettings machine;
  machine.heaters = {heater(0, 0, 300, 300, 150, 500)};
  machine.heaters[0].emissivity = 1;
  machine.reflector_mm = 150;
  const double full = black(500) - black(23);
  for (const double reflectance : {0.0, 0.5, 0.8, 1.0}) {
    machine.reflectance = reflectance;
    const Irradiance box(machine, {}, Irradiance::Side::above);
    for (const Eigen::Vector2d& place : {Eigen::Vector2d(0, 0), Eigen::Vector2d(60, 20),
                                         Eigen::Vector2d(-120, 140), Eigen::Vector2d(149, -149)}) {
      const double exact = reflectance == 1 ? 1.0 : by_images(place.x(), place.y(), 300, 150, reflectance);
      EXPECT_NEAR(box.above_surroundings(place) / full, exact, reflectance == 1 ? 1e-9 : 0.004)
          << reflectance << " at " << place.transpose();
    }
  }
}

// Walls that hang beside everything that the sheet sees change nothing; a lip takes away what it hides.
TEST(Irradiance, RaysThatMeetNothingAddNothing) {
  MachineSettings machine;
  machine.heaters = {heater(0, 0, 300, 300, 150, 500)};
  const Irradiance open(machine, {}, Irradiance::Side::above);
  machine.reflector_mm = 1e-3;
  const Irradiance trimmed(machine, {}, Irradiance::Side::above);
  EXPECT_NEAR(trimmed.above_surroundings({10, 30}), open.above_surroundings({10, 30}), 1e-9);

  machine.reflector_mm = 0;
  machine.lip_mm = 40;
  machine.heaters[0].width_mm = machine.heaters[0].height_mm = 2000;
  const Irradiance shaded(machine, {}, Irradiance::Side::above);
  const Irradiance bare(
      [&] {
        auto without = machine;
        without.lip_mm = 0;
        return without;
      }(),
      {}, Irradiance::Side::above);
  // What is left is what is seen through the lip's upper edge.
  const double full = 0.9 * (black(500) - black(23));
  const auto through = [&](double x, double y) {
    return view_factor(-140 - x, 140 - x, -140 - y, 140 - y, 40);
  };
  EXPECT_GT(bare.above_surroundings({0, 0}) / full, 0.97);
  EXPECT_NEAR(shaded.above_surroundings({0, 0}) / full, through(0, 0), 0.01);
  EXPECT_NEAR(shaded.above_surroundings({120, -70}) / full, through(120, -70), 0.02);
}

TEST(Irradiance, HasTheSymmetryOfTheSquare) {
  MachineSettings machine;
  machine.heaters = {heater(0, 0, 240, 240, 120, 500)};
  machine.reflector_mm = 60;
  machine.lip_mm = 10;
  const Irradiance box(machine, {}, Irradiance::Side::above);
  const double at = box.above_surroundings({90, 35});
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(35, 90), Eigen::Vector2d(-90, 35), Eigen::Vector2d(-35, -90)})
    EXPECT_NEAR(box.above_surroundings(place) / at, 1, 1e-6);
}

constexpr double never = 0;

// Flux q into one face of a slab, insulated on the other, all opaque: the exact series. At absolute zero, where nothing
// is radiated back.
TEST(Slab, FollowsTheExactSeries) {
  const double L = 1e-3, k = 0.2, diffusivity = 0.2 / (1270.0 * 1250.0), q = 50;
  constexpr int n = 64;
  const Slab slab({1270, 1250, k, 1, INFINITY}, 1, n);
  std::vector<double> celsius(n, absolute_zero);
  const double step = 0.01;
  double taken = 0;
  const auto exact = [&](double z, double t) {
    const double fourier = diffusivity * t / (L * L);
    double sum = 0;
    for (int m = 1; m < 200; ++m)
      sum += (m % 2 ? -1.0 : 1.0) / (m * m) *
             std::exp(-m * m * std::numbers::pi * std::numbers::pi * fourier) *
             std::cos(m * std::numbers::pi * z / L);
    return fourier + (3 * z * z - L * L) / (6 * L * L) - 2 / (std::numbers::pi * std::numbers::pi) * sum;
  };
  int compared = 0;
  for (int i = 1; i <= 2000; ++i) {
    taken += slab.advance(celsius, step, {q, never, 0}, {0, never, 0});
    if (i != 100 && i != 400 && i != 1000 && i != 2000) continue;
    for (int j = 0; j < n; ++j) {
      const double z = L * (1 - (j + 0.5) / n);  // the flux comes in at the top, z = L
      EXPECT_NEAR((celsius[j] - absolute_zero) * k / (q * L), exact(z, i * step), 1e-4)
          << i << ", layer " << j;
    }
    EXPECT_NEAR((Slab::top_celsius(celsius) - absolute_zero) * k / (q * L), exact(L, i * step), 2e-4);
    ++compared;
  }
  EXPECT_EQ(compared, 4);
  EXPECT_NEAR(taken / (q * 2000 * step), 1, 1e-9);
}

// All that comes in, by radiation in depth, air and re-radiation, is found again as energy of the sheet.
TEST(Slab, BalancesItsEnergy) {
  const Slab slab({1200, 1200, 0.2, 0.94, 3}, 0.8, 16);
  std::vector<double> celsius(16, 23);
  const double before = slab.energy(celsius);
  double taken = 0;
  for (int i = 0; i < 60; ++i) taken += slab.advance(celsius, 0.5, {14000, 8, 60}, {3000, 6, 40});
  EXPECT_GT(celsius[0], 100);
  EXPECT_NEAR(taken / (slab.energy(celsius) - before), 1, 1e-7);
}

// Without conduction each layer takes what Beer and Lambert leave it.
TEST(Slab, AbsorbsInDepth) {
  const Slab slab({1000, 1000, 1e-9, 0.9, 2}, 1, 10);
  std::vector<double> celsius(10, absolute_zero);
  slab.advance(celsius, 0.1, {40, never, 0}, {0, never, 0});
  for (int i = 0; i < 10; ++i) {
    const double share = std::exp(-0.2 * i) - std::exp(-0.2 * (i + 1));
    EXPECT_NEAR((celsius[i] - absolute_zero) / (0.1 * 40 * 0.9 * share / 100), 1, 1e-6) << i;
  }
}

// A slab of high conductivity cools as one lump: exp(-2 h t / (rho c L)).
TEST(Slab, CoolsInAirAsALump) {
  const Slab slab({1000, 1000, 1e4, 0, 5}, 1, 8);
  std::vector<double> celsius(8, 150);
  for (int i = 0; i < 100; ++i) slab.advance(celsius, 0.5, {0, 10, 20}, {0, 10, 20});
  EXPECT_NEAR(celsius[3], 20 + 130 * std::exp(-2 * 10 * 50 / 1000.0), 0.01);
}

TEST(Slab, KeepsTheTemperatureOfItsSurroundings) {
  const Slab slab({1000, 1000, 0.2, 0.9, 1.5}, 1, 16);
  std::vector<double> celsius(16, 130);
  for (int i = 0; i < 50; ++i) slab.advance(celsius, 2, {black(130), 8, 130}, {black(130), 8, 130});
  for (const double c : celsius) EXPECT_NEAR(c, 130, 1e-9);
}

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
    EXPECT_LT(stiffer, 3.6) << name(m);
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
