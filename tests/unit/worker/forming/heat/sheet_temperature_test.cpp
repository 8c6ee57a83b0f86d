// The temperature with which the sheet meets the mold, and what it does there.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/fixtures/shapes.hpp"
#include "tests/unit/worker/forming/heat/heaters.hpp"
#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/forming/material.hpp"
#include "worker/forming/temperature_findings.hpp"

namespace vacuform {
namespace {

TEST(SheetTemperature, SourcesAndTheirFiles) {
  HeatSettings heat;
  const auto uniform = sheet_temperature({}, {}, heat, std::nullopt, Context{});
  ASSERT_TRUE(uniform);
  EXPECT_EQ(uniform->field.at({3, 4}), material_profile(Material::petg).forming_celsius());
  EXPECT_EQ(uniform->summary.least, uniform->summary.most);
  heat.temperature_c = 133;
  EXPECT_EQ(sheet_temperature({}, {}, heat, std::nullopt, Context{})->field.at({0, 0}), 133);

  const std::string rows = "140,150\n130,140\n";
  const InputFile file{{rows.begin(), rows.end()}, "rows.csv"};
  heat.source = HeatSource::measured;
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
