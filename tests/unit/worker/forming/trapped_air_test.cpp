// Trapped air and vents: on sheets formed over molds of known shape, and on sheets made by hand.
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/forming/findings.hpp"

namespace vacuform::trapped_air_test {
namespace {

constexpr double R = 50;

FormedSheet formed_over(const Mold& mold) {
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = 200;
  sheet.resolution_mm = 5;
  MachineSettings machine;
  machine.window_width_mm = machine.window_height_mm = 180;
  auto formed = form(mold, sheet, machine, {}, TemperatureField(140), Context{});
  if (!formed) throw std::runtime_error(formed.error().text());
  return *formed;
}
Eigen::Vector3d on_dome(double polar, double around, double radius) {
  return radius * Eigen::Vector3d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                  std::cos(polar));
}
int count(const FormedSheet& sheet, const std::string& code) {
  return static_cast<int>(std::count_if(sheet.warnings.begin(), sheet.warnings.end(),
                                        [&](const Warning& w) { return w.code == code; }));
}

TEST(TrappedAir, ADomeHasNone) {
  const FormedSheet sheet = formed_over(hemisphere(R));
  EXPECT_TRUE(sheet.vents.empty());
  EXPECT_EQ(count(sheet, "trapped-air"), 0);
}

TEST(TrappedAir, ADimpleHasOneVentAtItsBottom) {
  const Mold mold = dented(hemisphere(R), 0.5, 0.7, 0.35, 6);
  const FormedSheet sheet = formed_over(mold);
  ASSERT_EQ(sheet.vents.size(), 1u);
  EXPECT_LT((sheet.vents[0].place - on_dome(0.5, 0.7, R - 6)).norm(), 5);  // one cell of the grid
  EXPECT_EQ(sheet.vents[0].diameter_mm, 1);
  ASSERT_EQ(count(sheet, "trapped-air"), 1);
  const auto pockets = trapped_air(sheet, mold.mesh);
  ASSERT_EQ(pockets.size(), 1u);
  // Where the film touches around it, it has spanned most of the dent: less than its disk, and than its depth.
  const double disk = std::numbers::pi * std::pow(R * std::sin(0.35), 2);
  EXPECT_GT(pockets[0].area_mm2, 0.3 * disk);
  EXPECT_LT(pockets[0].area_mm2, disk);
  EXPECT_GT(pockets[0].depth_mm, 2);
  EXPECT_LT(pockets[0].depth_mm, 6);
}

TEST(TrappedAir, TwoEyeSocketsHaveAVentEach) {
  const Mold mold = dented(dented(hemisphere(R), 0.7, 0.6, 0.35, 6), 0.7, -0.6, 0.35, 6);
  const FormedSheet sheet = formed_over(mold);
  ASSERT_EQ(sheet.vents.size(), 2u);
  for (const double around : {0.6, -0.6}) {
    double nearest = HUGE_VAL;
    for (const Vent& vent : sheet.vents)
      nearest = std::min(nearest, (vent.place - on_dome(0.7, around, R - 6)).norm());
    EXPECT_LT(nearest, 5);
  }
  for (const Warning& w : sheet.warnings)
    if (w.code == "trapped-air") {
      EXPECT_EQ(w.marks.size(), 2u);
      EXPECT_TRUE(w.text.ends_with("the largest of 2 places")) << w.text;
      EXPECT_TRUE(w.what_to_do().starts_with("Drill 2 vents of 1 mm: ")) << w.what_to_do();
      ASSERT_TRUE(w.figure && w.figure->limit);
      EXPECT_GT(w.figure->value, *w.figure->limit);
    }
}

// A bowl in a sheet of 30 x 30 cells of 4 mm that lies on the mold: `deep` below its rim, `wide` across, filled from
// its rim inwards after the rest has touched.
struct Bowl {
  double deep = 6, wide = 40;
  FormedSheet sheet() const {
    FormedSheet s;
    constexpr int n = 30;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const Eigen::Vector2d st(4 * i - 60, 4 * j - 60);
        const double r = 2 * st.norm() / wide;
        s.rest.push_back(st);
        s.formed.emplace_back(st.x(), st.y(), 30 - (r < 1 ? deep * (1 - r * r) : 0));
        s.contact.push_back(st.cwiseAbs().maxCoeff() > 59 ? Contact::clamp : Contact::mold);
        s.contact_time.push_back(r < 1 ? 2 - r : 0.5);
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = (n + 1) * j + i, b = a + 1, c = b + n + 1, d = a + n + 1;
        s.triangles.push_back({a, b, c});
        s.triangles.push_back({a, c, d});
      }
    s.element_thickness.assign(s.triangles.size(), 1);
    s.element_wrinkled.assign(s.triangles.size(), 0);
    return s;
  }
};

TEST(TrappedAir, ABowlIsMeasured) {
  const auto pockets = trapped_air(Bowl{}.sheet(), {});
  ASSERT_EQ(pockets.size(), 1u);
  EXPECT_NEAR(pockets[0].area_mm2, std::numbers::pi * 20 * 20, 150);
  EXPECT_NEAR(pockets[0].depth_mm, 6, 0.5);
  EXPECT_EQ(pockets[0].closed, 0.5);
  const auto vents = vents_for(pockets, Bowl{}.sheet(), {}, 3);
  ASSERT_EQ(vents.size(), 1u);
  EXPECT_LT((vents[0].place - Eigen::Vector3d(0, 0, 24)).norm(), 1e-9);
  EXPECT_EQ(vents[0].diameter_mm, 1.5);  // half of a thick sheet
}

TEST(TrappedAir, IgnoresShallowOrTinyPockets) {
  EXPECT_TRUE(trapped_air(Bowl{0.4, 40}.sheet(), {}).empty());
  EXPECT_TRUE(trapped_air(Bowl{6, 6}.sheet(), {}).empty());
  EXPECT_TRUE(trapped_air(Bowl{-6, 40}.sheet(), {}).empty());  // a bump is reached last, and shuts in nothing
}

// The same bowl open to the platform through a slot: the vacuum drains it.
TEST(TrappedAir, DrainsAPocketThatReachesThePlatform) {
  FormedSheet sheet = Bowl{}.sheet();
  for (std::size_t v = 0; v < sheet.rest.size(); ++v)
    if (sheet.rest[v].y() == 0 && sheet.rest[v].x() > 0 && sheet.contact[v] == Contact::mold)
      sheet.contact[v] = Contact::platform;
  EXPECT_TRUE(trapped_air(sheet, {}).empty());
}

// A trough that fills everywhere at once along its bottom wants a row of vents.
TEST(TrappedAir, VentsKeepTheirDistance) {
  FormedSheet sheet = Bowl{}.sheet();
  for (std::size_t v = 0; v < sheet.rest.size(); ++v) {
    const double r = std::abs(sheet.rest[v].y()) / 12;
    const bool inside = r < 1 && std::abs(sheet.rest[v].x()) < 51;
    sheet.formed[v].z() = inside ? 30 - 6 * (1 - r * r) : 30;
    sheet.contact_time[v] = inside ? 2 - r : 0.5;
  }
  const auto vents = vents_for(trapped_air(sheet, {}), sheet, {}, 1);
  EXPECT_GE(vents.size(), 3u);
  EXPECT_LE(vents.size(), 5u);  // 96 mm
  for (std::size_t a = 0; a < vents.size(); ++a) {
    EXPECT_EQ(vents[a].place.y(), 0);
    for (std::size_t b = 0; b < a; ++b) EXPECT_GE((vents[a].place - vents[b].place).norm(), 25);
  }
}

// Where the sheet never arrives, the hole goes into the mold below its highest point.
TEST(TrappedAir, AFreePocketIsVentedOnTheMold) {
  FormedSheet sheet = Bowl{1, 40}.sheet();
  for (std::size_t v = 0; v < sheet.rest.size(); ++v)
    if (sheet.contact_time[v] > 1) {
      sheet.contact[v] = Contact::free;
      sheet.contact_time[v] = std::numeric_limits<double>::quiet_NaN();
    }
  TriangleMesh floor;
  floor.vertices = {{-100, -100, 10}, {200, -100, 10}, {-100, 200, 10}};
  floor.triangles = {{0, 1, 2}};
  const auto pockets = trapped_air(sheet, floor);
  ASSERT_EQ(pockets.size(), 1u);
  EXPECT_NEAR(pockets[0].depth_mm, 20, 0.1);
  for (const Vent& vent : vents_for(pockets, sheet, floor, 1)) EXPECT_NEAR(vent.place.z(), 10, 1e-3);
}

}  // namespace
}  // namespace vacuform::trapped_air_test
