// Heat: view factors, rays between reflectors, the slab, and the plastics against PHYSICS' exact cases.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "tests/unit/shapes.hpp"
#include "worker/forming/heat/gray_png.hpp"
#include "worker/forming/heat/heating.hpp"
#include "worker/forming/heat/irradiance.hpp"
#include "worker/forming/heat/scattered.hpp"
#include "worker/forming/heat/sheet_temperature.hpp"
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

// A flat 300 x 450 panel at 75 to 200 mm gives the corners of a sheet of its size, 10 mm in under the clamp, only 0.36 to
// 0.44 of the centre.
TEST(Irradiance, OfAPanelAtTheCornersOfTheSheet) {
  HeatSettings heat;
  for (const auto& [z, share] : {std::pair(75.0, 0.36), std::pair(200.0, 0.44)}) {
    MachineSettings machine;
    machine.heaters = {heater(0, 0, 300, 450, z, 500)};
    const Irradiance panel(machine, heat, Irradiance::Side::above);
    EXPECT_NEAR(panel.above_surroundings({140, 215}) / panel.above_surroundings({0, 0}), share, 0.005) << z;
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

// Behind a reflector that reaches the sheet it is dark, and through a round lip the sheet sees a round part of the heater:
// R^2 / (R^2 + h^2) of its half space.
TEST(Irradiance, WallsHideWhatIsBehindThem) {
  MachineSettings machine;
  machine.heaters = {heater(0, 0, 200, 200, 100, 500)};
  machine.reflector_mm = 100;
  const Irradiance box(machine, {}, Irradiance::Side::above);
  const double full = 0.9 * (black(500) - black(23));
  EXPECT_NEAR(box.above_surroundings({130, 20}) / full, 0, 1e-9);
  EXPECT_GT(box.above_surroundings({95, 20}) / full, 0.5);

  machine.reflector_mm = 0;
  machine.heaters[0].width_mm = machine.heaters[0].height_mm = 4000;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 200;
  machine.lip_mm = 50;
  const Irradiance ring(machine, {}, Irradiance::Side::above);
  EXPECT_NEAR(ring.above_surroundings({0, 0}) / full, 0.8, 0.01);
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

// Long steps under a fierce heater end in the balance of what comes in and what is radiated back.
TEST(Slab, ComesToRestInLongSteps) {
  const Slab slab({1270, 1250, 0.2, 0.94, 3}, 1, 10);
  std::vector<double> celsius(10, 23);
  for (int i = 0; i < 20; ++i) slab.advance(celsius, 90, {black(1200), 0, 23}, {black(1200), 0, 23});
  for (const double c : celsius) EXPECT_NEAR(c, 1200, 1e-3);
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

// A bank of 4 x 3 panels over a sheet of 300 x 300.
MachineSettings bank(double celsius) {
  MachineSettings machine;
  for (int j = -1; j <= 1; ++j)
    for (int i = 0; i < 4; ++i)
      machine.heaters.push_back(heater(100 * i - 150, 100 * j, 100, 100, 120, celsius));
  return machine;
}

double mean_over_window(const TemperatureField& field) {
  double sum = 0;
  for (int j = 0; j < 140; ++j)
    for (int i = 0; i < 140; ++i) sum += field.at({2 * i - 139.0, 2 * j - 139.0});
  return sum / (140 * 140);
}

TEST(Heating, StopsWhenTheSheetWillBeWarmEnoughOnTheMold) {
  HeatSettings heat;
  heat.source = HeatSource::heaters;
  heat.temperature_c = 145;
  for (const auto& [transfer, celsius] : {std::pair(0.0, 450.0), std::pair(15.0, 600.0)}) {
    heat.transfer_seconds = transfer;
    const auto heated = heat_sheet({}, bank(celsius), heat, Context{});
    ASSERT_TRUE(heated) << heated.error().text();
    EXPECT_NEAR(mean_over_window(heated->field), 145, 0.1);
    EXPECT_GT(heated->field.at({0, 0}), heated->field.at({135, 135}) + 20);
    EXPECT_NEAR(heated->field.at({70, 40}), heated->field.at({-70, -40}), 1e-6);
    EXPECT_EQ(heated->field.at({149, 0}), heated->field.at({140, 0}));  // under the frame
    // By hand: about 1.6 MJ/m3K and 1 mm against the flux that the middle gets at first, and losses.
    EXPECT_GT(heated->seconds, 15);
    EXPECT_LT(heated->seconds, 60);
    EXPECT_GT(heated->through_thickness, 0.2);
    EXPECT_LT(heated->through_thickness, 20);
  }
}

// A given time is one number: the slab of the middle, advanced by hand.
TEST(Heating, OfAGivenTimeIsThatOfItsSlab) {
  HeatSettings heat;
  heat.seconds = 30;
  heat.transfer_seconds = 0;
  const MachineSettings machine = bank(450);
  const auto heated = heat_sheet({}, machine, heat, Context{});
  ASSERT_TRUE(heated);
  const MaterialProfile m = material_profile(Material::petg);
  const Slab slab(
      {m.density_kg_m3, m.heat_capacity_j_kgk, m.conductivity_w_mk, m.emissivity, m.absorption_1_mm}, 1, 64);
  std::vector<double> celsius(64, 23);
  const double above = Irradiance(machine, heat, Irradiance::Side::above).above_surroundings({0, 0});
  for (int i = 0; i < 600; ++i) slab.advance(celsius, 0.05, {above + black(23), 7, 23}, {black(23), 7, 23});
  EXPECT_NEAR(heated->field.at({0, 0}), slab.energy(celsius) / slab.energy(std::vector<double>(64, 1.0)),
              0.02);
  EXPECT_EQ(heated->seconds, 30);
}

// A stronger rim evens out what a flat bank leaves cold.
TEST(Heating, ZonesEvenOutTheSheet) {
  MachineSettings machine = bank(450);
  for (Heater& h : machine.heaters) h.zone = std::abs(h.x_mm) > 100 || h.y_mm != 0 ? "rim" : "middle";
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = 150;  // fewer places; the bank stays as wide
  machine.window_width_mm = machine.window_height_mm = 140;
  machine.heaters.erase(machine.heaters.begin(), machine.heaters.begin() + 4);  // the lower row
  const auto spread = [&](double rim, double middle) {
    HeatSettings heat;
    heat.gains = {{"rim", rim}, {"middle", middle}};
    const auto heated = heat_sheet(sheet, machine, heat, Context{});
    EXPECT_TRUE(heated);
    return heated->field.at({0, 70}) - heated->field.at({0, -70});
  };
  const double even = spread(1, 1);
  EXPECT_GT(even, 10);
  EXPECT_LT(spread(0.7, 1), even - 10);
}

TEST(Heating, OfHeatersTooWeakIsRefusedByName) {
  HeatSettings heat;
  for (const double celsius : {23.0, 60.0, 160.0}) {
    const auto heated = heat_sheet({}, bank(celsius), heat, Context{});
    ASSERT_FALSE(heated) << celsius;
    EXPECT_EQ(heated.error().code, Code::bad_settings);
    EXPECT_EQ(heated.error().where, "machine.heaters");
  }
  heat.ambient_c = 150;
  EXPECT_EQ(heat_sheet({}, bank(450), heat, Context{}).error().where, "heat.ambient_c");
  Context cancelled;
  cancelled.cancel();
  EXPECT_EQ(heat_sheet({}, bank(450), heat, cancelled).error().code, Code::cancelled);
}

TEST(Heating, SameInputSameBytes) {
  MachineSettings machine = bank(450);
  machine.reflector_mm = 60;
  HeatSettings heat;
  heat.seconds = 20;
  SheetSettings sheet;
  sheet.height_mm = 100;
  const auto a = heat_sheet(sheet, machine, heat, Context{}), b = heat_sheet(sheet, machine, heat, Context{});
  ASSERT_TRUE(a && b);
  for (double s = -150; s <= 150; s += 7) {
    const double x = a->field.at({s, s / 3}), y = b->field.at({s, s / 3});
    EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0);
  }
}

Result<TemperatureField> measured(const std::string& text, const HeatSettings& heat = {}) {
  return read_measured_field({{reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, "field.csv"},
                             {}, heat);
}

// 300 x 300 mm in two rows of three: the first row lies along the upper edge.
TEST(Measured, RowsTileTheSheetFromTheTop) {
  for (const char* text : {"150,151,152\n120,121,122\n",
                           "\xef\xbb\xbf"
                           "150;151,0;152\r\n120;121;122",
                           "# camera 3\n\n150 151\t152\n120 121 122\n", "150, 151, 152,\n120, 121, 122,\n"}) {
    const auto field = measured(text);
    ASSERT_TRUE(field) << field.error().text();
    EXPECT_NEAR(field->at({-100, 75}), 150, 1e-12) << text;
    EXPECT_NEAR(field->at({100, 75}), 152, 1e-12);
    EXPECT_NEAR(field->at({0, -75}), 121, 1e-12);
    EXPECT_NEAR(field->at({50, 0}), (151.5 + 121.5) / 2, 1e-12);
    EXPECT_NEAR(field->at({149, 149}), 152, 1e-12);
  }
  EXPECT_EQ(measured("141.5")->at({30, 20}), 141.5);
}

TEST(Measured, PointsAreInterpolatedSmoothlyAndExactly) {
  const auto field =
      measured("t_mm;s_mm;Celsius\n0;0;150\n100;-100;130,5\n100;100;131\n-100;100;129\n-100;-100;130\n");
  ASSERT_TRUE(field) << field.error().text();
  EXPECT_NEAR(field->at({0, 0}), 150, 1e-6);
  EXPECT_NEAR(field->at({-100, 100}), 130.5, 1e-6);
  EXPECT_NEAR(field->at({100, -100}), 129, 1e-6);
  const double half = field->at({50, 0});
  EXPECT_GT(half, 138);
  EXPECT_LT(half, 150);
  EXPECT_GE(field->at({150, 150}), 129);  // no wilder than what was measured
  EXPECT_LE(field->at({150, 150}), 150);
}

TEST(Measured, PointsOfAPlaneGiveThePlane) {
  std::vector<MeasuredPoint> points;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d p(140 * std::sin(7.0 * i), 140 * std::cos(5.0 * i));
    points.push_back({p, 140 + 0.05 * p.x() - 0.02 * p.y()});
  }
  const TemperatureField field = through_points(points, 300, 300);
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(20, 35), Eigen::Vector2d(-70, 60), Eigen::Vector2d(0, -90)})
    EXPECT_NEAR(field.at(p), 140 + 0.05 * p.x() - 0.02 * p.y(), 1e-6);
  // One point, points on a line, and twice the same point are no trouble.
  EXPECT_NEAR(through_points({{{10, 20}, 133}}, 300, 300).at({-50, 0}), 133, 1e-9);
  const TemperatureField line = through_points({{{-100, 0}, 120}, {{0, 0}, 130}, {{100, 0}, 140}}, 300, 300);
  EXPECT_NEAR(line.at({50, 0}), 135, 1);
  EXPECT_NEAR(line.at({50, 80}), line.at({50, -80}), 1e-6);
  const TemperatureField twice = through_points({{{0, 0}, 120}, {{0, 0}, 130}}, 300, 300);
  EXPECT_NEAR(twice.at({0, 0}), 125, 1e-9);
  // More than 400: merged, and still the plane.
  points.clear();
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector2d p((i * 37 % 301) - 150, (i * 101 % 299) - 149);
    points.push_back({p, 140 + 0.05 * p.x()});
  }
  EXPECT_NEAR(through_points(points, 300, 300).at({80, 20}), 144, 0.05);
}

TEST(Measured, WhatIsWrongIsSaidWithItsLine) {
  struct Case {
    const char *text, *where, *says;
  };
  for (const Case& c :
       {Case{"", "field.csv", "no temperature"}, Case{"\n# only words\n", "field.csv", "no temperature"},
        Case{"140,141\n140\n", "field.csv, line 2", "a row of 1"},
        Case{"140,x\n", "field.csv, line 1", "not a number: \"x\""},
        Case{"140,nan\n", "field.csv, line 1", "not a number"},
        Case{"140,,141", "field.csv, line 1", "not a number"},
        Case{"413.15,414\n1000,410", "field.csv, line 2", "1000 C"},
        Case{"s,t\n1,2", "field.csv, line 1", "columns s, t and celsius"},
        Case{"s,t,celsius\n", "field.csv, line 1", "no point"},
        Case{"s,t,celsius\n1,2,140\n1,2", "field.csv, line 3", "not a number"},
        Case{"s,t,celsius\n900,2,140", "field.csv, line 2", "off the sheet"},
        Case{"s,t,celsius\n1,,140", "field.csv, line 2", "two numbers"},
        Case{"\x01\x02\xff\xfe", "field.csv, line 1", "not a number: \"??"}}) {
    const auto field = measured(c.text);
    ASSERT_FALSE(field) << c.text;
    EXPECT_EQ(field.error().code, Code::corrupt_file) << c.text;
    EXPECT_EQ(field.error().where, c.where) << c.text;
    EXPECT_NE(field.error().what.find(c.says), std::string::npos) << field.error().text();
  }
}

// A gray PNG of 3 x 2 pixels of 8 bits: 0, 51, 102 over 153, 204, 255. Written once with Python's zlib.
constexpr std::uint8_t gray_3x2[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
    0x52, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x02, 0x08, 0x00, 0x00, 0x00, 0x00, 0xb8,
    0x1f, 0x39, 0xc6, 0x00, 0x00, 0x00, 0x10, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0x60,
    0x30, 0x4e, 0x63, 0x98, 0x79, 0xe6, 0x3f, 0x00, 0x07, 0x9a, 0x02, 0xfe, 0x07, 0xb3, 0x50,
    0x57, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

TEST(Measured, GrayPicturesNeedAScale) {
  HeatSettings heat;
  EXPECT_EQ(read_measured_field({gray_3x2, "camera.png"}, {}, heat).error().where, "heat.black_c");
  heat.black_c = 100;
  heat.white_c = 200;
  const auto field = read_measured_field({gray_3x2, "camera.png"}, {}, heat);
  ASSERT_TRUE(field) << field.error().text();
  EXPECT_NEAR(field->at({-100, 75}), 100, 1e-9);
  EXPECT_NEAR(field->at({0, 75}), 120, 1e-9);
  EXPECT_NEAR(field->at({100, -75}), 200, 1e-9);
  // Cut anywhere, or with any byte changed, it is refused or read, and never more than that.
  for (std::size_t n = 0; n < sizeof gray_3x2; ++n)
    EXPECT_FALSE(read_gray_png(std::span(gray_3x2).first(n), "camera.png")) << n;
  for (std::size_t i = 8; i < sizeof gray_3x2; ++i) {
    auto bytes = std::to_array(gray_3x2);
    bytes[i] ^= 0x55;
    const auto picture = read_gray_png(bytes, "camera.png");
    EXPECT_TRUE(!picture || picture->pixels.size() == 6) << i;
  }
  auto colour = std::to_array(gray_3x2);
  colour[25] = 2;
  EXPECT_EQ(read_gray_png(colour, "camera.png").error().code, Code::unsupported_format);
  auto huge = std::to_array(gray_3x2);
  huge[17] = 1;  // 65,539 pixels wide
  huge[22] = 1;
  EXPECT_EQ(read_gray_png(huge, "camera.png").error().code, Code::too_large);
}

TEST(SheetTemperature, SourcesAndTheirFiles) {
  HeatSettings heat;
  const auto uniform = sheet_temperature({}, {}, heat, std::nullopt, Context{});
  ASSERT_TRUE(uniform);
  EXPECT_EQ(uniform->field.at({3, 4}), material_profile(Material::petg).forming_celsius());
  EXPECT_EQ(uniform->summary.least, uniform->summary.most);
  heat.temperature_c = 133;
  EXPECT_EQ(sheet_temperature({}, {}, heat, std::nullopt, Context{})->field.at({0, 0}), 133);

  const std::string rows = "140,150\n130,140\n";
  const MeasuredFile file{{reinterpret_cast<const std::uint8_t*>(rows.data()), rows.size()}, "rows.csv"};
  EXPECT_EQ(sheet_temperature({}, {}, heat, file, Context{}).error().code, Code::bad_usage);
  heat.source = HeatSource::measured;
  EXPECT_EQ(sheet_temperature({}, {}, heat, std::nullopt, Context{}).error().code, Code::bad_settings);
  const auto warm = sheet_temperature({}, {}, heat, file, Context{});
  ASSERT_TRUE(warm);
  EXPECT_NEAR(warm->summary.least, 130, 1e-9);
  EXPECT_NEAR(warm->summary.mean, 140, 1e-9);
  EXPECT_NEAR(warm->summary.most, 150, 1e-9);
}

TEST(SheetTemperature, ThickSheetHeatedFromOneSideIsUneven) {
  SheetSettings sheet;
  sheet.thickness_mm = 4;
  sheet.width_mm = sheet.height_mm = 100;
  MachineSettings machine;
  machine.window_width_mm = machine.window_height_mm = 80;
  machine.heaters = {heater(0, 0, 300, 300, 100, 550)};
  HeatSettings heat;
  heat.source = HeatSource::heaters;
  const auto one_side = sheet_temperature(sheet, machine, heat, std::nullopt, Context{});
  ASSERT_TRUE(one_side) << one_side.error().text();
  ASSERT_EQ(one_side->warnings.size(), 1u);
  EXPECT_EQ(one_side->warnings[0].code, "uneven-through");
  machine.heaters = {heater(0, 0, 300, 300, 150, 350), heater(0, 0, 300, 300, -150, 350)};
  const auto both = sheet_temperature(sheet, machine, heat, std::nullopt, Context{});
  ASSERT_TRUE(both) << both.error().text();
  EXPECT_TRUE(both->warnings.empty());
  EXPECT_LT(*both->summary.through_thickness, *one_side->summary.through_thickness / 2);
}

TEST(TemperatureFindings, SayWhereThePlasticIsOutOfItsWindow) {
  FormedSheet sheet;
  for (int i = 0; i <= 20; ++i) {
    sheet.rest.emplace_back(10 * i - 100, 0);
    sheet.formed.emplace_back(10 * i - 100, 0, 30);
    sheet.temperature.push_back(140);
    sheet.contact.push_back(Contact::mold);
  }
  EXPECT_TRUE(temperature_findings(sheet, Material::petg).empty());
  sheet.temperature[0] = 20;  // held by the frame
  sheet.contact[0] = Contact::clamp;
  EXPECT_TRUE(temperature_findings(sheet, Material::petg).empty());
  sheet.temperature[2] = 109;
  sheet.temperature[3] = 115;  // beside it: no mark of its own
  sheet.temperature[9] = 119;
  sheet.temperature[18] = 167;
  const auto found = temperature_findings(sheet, Material::petg);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].code, "too-cold");
  EXPECT_NE(found[0].text.find("up to 12 degrees colder than PETG forms (121 to 160 C): 109 C at x = -80 mm"),
            std::string::npos)
      << found[0].text;
  EXPECT_NE(found[0].text.find("over 15 % of it"), std::string::npos) << found[0].text;
  ASSERT_EQ(found[0].marks.size(), 2u);
  EXPECT_EQ(found[0].marks[0].place_mm[0], -80);
  EXPECT_EQ(found[0].marks[1].place_mm[0], -10);
  EXPECT_EQ(found[1].code, "too-hot");
  EXPECT_NE(found[1].text.find("7 degrees hotter"), std::string::npos) << found[1].text;
}

// On a head of 85 mm under a ring of 1.5 radii a rim ten degrees colder than the middle moves the print 2.6 mm at 60
// degrees from the top, 3.0 mm at 75.
TEST(Heat, AColderRimMovesThePrintByMillimetres) {
  constexpr double R = 85;
  const Mold mold = hemisphere(R, 90, 180);
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 3 * R;
  SheetSettings sheet;
  sheet.resolution_mm = 6;
  const double middle = material_profile(Material::petg).forming_celsius();
  std::vector<double> celsius;
  for (int j = 0; j <= 100; ++j)
    for (int i = 0; i <= 100; ++i) {
      const double r = Eigen::Vector2d(3 * i - 150, 3 * j - 150).norm() / (1.5 * R);
      celsius.push_back(middle - 10 * std::min(1.0, r * r));
    }
  // Mean sheet radius that lands at a polar angle.
  const auto lands_at = [&](const FormedSheet& formed, double angle) {
    double sum = 0, count = 0;
    const auto polar = [&](int v) {
      const Eigen::Vector3d& p = formed.formed[static_cast<std::size_t>(v)];
      return std::atan2(p.head<2>().norm(), p.z()) * 180 / std::numbers::pi - angle;
    };
    for (const Triangle& t : formed.triangles)
      for (std::size_t e = 0; e < 3; ++e) {
        const int a = t[e], b = t[(e + 1) % 3];
        const double pa = polar(a), pb = polar(b);
        if (pa * pb >= 0 || formed.contact[static_cast<std::size_t>(a)] != Contact::mold ||
            formed.contact[static_cast<std::size_t>(b)] != Contact::mold)
          continue;
        const double w = pa / (pa - pb);
        sum += (1 - w) * formed.rest[static_cast<std::size_t>(a)].norm() +
               w * formed.rest[static_cast<std::size_t>(b)].norm();
        count += 1;
      }
    return sum / count;
  };
  const auto even = form(mold, sheet, machine, {}, TemperatureField(middle), Context{});
  const auto colder = form(mold, sheet, machine, {}, TemperatureField(300, 300, 101, celsius), Context{});
  ASSERT_TRUE(even && colder);
  EXPECT_NEAR(lands_at(*even, 60) - lands_at(*colder, 60), 2.6, 0.4);
  EXPECT_NEAR(lands_at(*even, 75) - lands_at(*colder, 75), 3.0, 0.4);
}

}  // namespace
}  // namespace vacuform
