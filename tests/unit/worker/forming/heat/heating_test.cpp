// The sheet under its heaters.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/worker/forming/heat/heaters.hpp"
#include "worker/forming/heat/heating.hpp"
#include "worker/forming/heat/slab.hpp"
#include "worker/forming/material.hpp"

namespace vacuform {
namespace {

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
TEST(Heating, MatchesTheSlabAtAGivenTime) {
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

TEST(Heating, RefusesHeatersThatAreTooWeakByName) {
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

}  // namespace
}  // namespace vacuform
