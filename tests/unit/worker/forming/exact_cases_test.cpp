// Forming against independent solutions of axisymmetric forming: other rings, angles and laws than the tables have.
#include <gtest/gtest.h>

#include "tests/unit/fixtures/shapes.hpp"
#include "tests/unit/worker/forming/axisymmetric.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform::exact_cases_test {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr MembraneLaw neo = MembraneLaw::neo_hookean, mooney = MembraneLaw::mooney_rivlin;

// The reference itself against the tables of converged solutions.
TEST(ExactCases, ShootingReproducesTheTables) {
  const auto cone = exact::female_cone(neo, 60 * degree);
  for (const auto& [place, thickness] :
       {std::pair{.02, .8367}, {.10, .7509}, {.25, .5888}, {.50, .3011}, {.75, .0765}})
    EXPECT_NEAR(exact::at(cone, place).thickness, thickness, 0.015 * thickness) << place;
  const auto hemisphere = exact::male_hemisphere(neo, 1.5, 86 * degree);
  for (const auto& [polar, rest, thickness] : {std::tuple{15, .2594, .974},
                                               {30, .5032, .885},
                                               {45, .7132, .719},
                                               {60, .8913, .698},
                                               {75, 1.0618, .668},
                                               {85, 1.1586, .560}}) {
    EXPECT_NEAR(exact::at(hemisphere, polar * degree).rest, rest, 2e-4) << polar;
    EXPECT_NEAR(exact::at(hemisphere, polar * degree).thickness, thickness, 0.005 * thickness) << polar;
  }
}

// Where edges of the sheet on the mold cross a level of `measure`: landing radius and thickness.
struct Crossings {
  double mean_rest = 0, least_rest = HUGE_VAL, most_rest = 0, mean_thickness = 0;
  int count = 0;
};
template <class Measure>
Crossings crossings(const FormedSheet& sheet, double level, Measure&& measure) {
  Crossings out;
  for (const Triangle& t : sheet.triangles)
    for (int e = 0; e < 3; ++e) {
      const int a = t[e], b = t[(e + 1) % 3];
      const double ma = measure(sheet.formed[a]) - level, mb = measure(sheet.formed[b]) - level;
      if (sheet.contact[a] != Contact::mold || sheet.contact[b] != Contact::mold || ma * mb >= 0) continue;
      const double w = ma / (ma - mb), rest = (1 - w) * sheet.rest[a].norm() + w * sheet.rest[b].norm();
      out.mean_rest += rest;
      out.least_rest = std::min(out.least_rest, rest), out.most_rest = std::max(out.most_rest, rest);
      out.mean_thickness += (1 - w) * sheet.thickness[a] + w * sheet.thickness[b];
      ++out.count;
    }
  out.mean_rest /= out.count, out.mean_thickness /= out.count;
  return out;
}

class HemisphereUnderARing : public testing::TestWithParam<std::pair<double, MembraneLaw>> {};
TEST_P(HemisphereUnderARing, LandsAndThinsAsTheShootingSays) {
  const auto [ring, law] = GetParam();
  constexpr double R = 85;
  SheetSettings sheet;
  sheet.resolution_mm = 5;
  sheet.width_mm = sheet.height_mm = 2 * ring * R + 10;
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 2 * ring * R;
  FormingSettings forming;
  forming.law = law;
  const auto formed =
      form(hemisphere(R, 180, 360), sheet, machine, forming, TemperatureField(140), Context{});
  ASSERT_TRUE(formed) << formed.error().text();
  const auto exact = exact::male_hemisphere(law, ring, 81 * degree);
  for (const double polar : {20, 35, 50, 65, 80}) {
    const auto wanted = exact::at(exact, polar * degree);
    const auto found = crossings(*formed, polar * degree, [](const Eigen::Vector3d& p) {
      return std::atan2(p.head<2>().norm(), p.z());
    });
    ASSERT_GT(found.count, 20);
    EXPECT_NEAR(found.least_rest, wanted.rest * R, 0.25) << polar << " degrees";
    EXPECT_NEAR(found.most_rest, wanted.rest * R, 0.25) << polar << " degrees";
    // Near the platform the thickness falls by a tenth within one cell.
    EXPECT_NEAR(found.mean_thickness, wanted.thickness, (polar < 70 ? 0.01 : 0.035) * wanted.thickness)
        << polar << " degrees";
  }
}
INSTANTIATE_TEST_SUITE_P(Rings, HemisphereUnderARing,
                         testing::Values(std::pair{1.3, neo}, std::pair{1.5, mooney}, std::pair{2.0, neo}));

}  // namespace
}  // namespace vacuform::exact_cases_test
