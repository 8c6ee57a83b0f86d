// View factors against exact values, rays between reflectors against sums over images.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/worker/forming/heat/heaters.hpp"
#include "worker/forming/heat/irradiance.hpp"
#include "worker/forming/heat/view_factor.hpp"

namespace vacuform {
namespace {

TEST(ViewFactor, MatchesCornersAndCentredSquares) {
  EXPECT_NEAR(view_factor(0, 1, 0, 1, 1), 0.138532, 1e-6);
  EXPECT_NEAR(view_factor(-1, 1, -1, 1, 1), 0.554126, 1e-6);
  EXPECT_NEAR(view_factor(-100, 100, -100, 100, 100), 0.554126, 1e-6);
  EXPECT_NEAR(view_factor(-1e9, 1e9, -1e9, 1e9, 1), 1, 1e-8);
}

// Anywhere: the parts of a rectangle add up to it, and a small one is cos^2 / (pi r^2) of its area.
TEST(ViewFactor, MatchesRectanglesAnywhere) {
  const double whole = view_factor(30, 90, -20, 50, 40);
  EXPECT_NEAR(view_factor(30, 70, -20, 50, 40) + view_factor(70, 90, -20, 50, 40), whole, 1e-15);
  EXPECT_NEAR(view_factor(-90, -30, -20, 50, 40), whole, 1e-15);
  const double x = 30, y = -50, h = 40, r2 = x * x + y * y + h * h;
  EXPECT_NEAR(
      view_factor(x - 0.05, x + 0.05, y - 0.05, y + 0.05, h) / (0.01 * h * h / (std::numbers::pi * r2 * r2)),
      1, 1e-5);
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

TEST(Irradiance, FollowsPowerAndGain) {
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
TEST(Irradiance, MatchesAPanelAtTheCornersOfTheSheet) {
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

}  // namespace
}  // namespace vacuform
