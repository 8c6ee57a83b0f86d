// What is measured between the formed sheet and the mold.
#include <gtest/gtest.h>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/forming/surface_fit.hpp"

namespace vacuform::surface_fit_test {
namespace {

// A level square sheet of 100 x 100 mm in cells of 2 mm, at a height, all of it said to touch the mold.
struct Level {
  std::vector<Triangle> triangles;
  std::vector<Eigen::Vector3d> formed;
  std::vector<Contact> contact;

  explicit Level(double height) {
    constexpr int n = 50;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) formed.emplace_back(2 * i - n, 2 * j - n, height);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i;
        triangles.push_back({a, a + 1, a + n + 2});
        triangles.push_back({a, a + n + 2, a + n + 1});
      }
    contact.assign(formed.size(), Contact::mold);
  }
  SurfaceFit on(const TriangleMesh& mold) const { return surface_fit(triangles, formed, contact, mold); }
};

TEST(SurfaceFit, MeasuresHowFarTheMoldStandsOut) {
  const TriangleMesh dome = hemisphere(30).mesh;
  const SurfaceFit fit = Level(22).on(dome);
  EXPECT_NEAR(fit.penetration.max, 8, 1e-4);
  EXPECT_NEAR(fit.penetration.place.z(), 30, 1e-9);
  EXPECT_GT(fit.penetration.p99, 7);  // the cap's area goes evenly with its height
}

TEST(SurfaceFit, NamesEveryPlaceWhereTheMoldStandsOut) {
  TriangleMesh domes;
  for (const auto& [x, scale] : {std::pair{-25.0, 1.0}, {25.0, 1.05}}) {
    const TriangleMesh dome = hemisphere(20).mesh;
    const int first = static_cast<int>(domes.vertices.size());
    for (const auto& p : dome.vertices) domes.vertices.push_back(scale * p + Eigen::Vector3d(x, 0, 0));
    for (const auto& t : dome.triangles)
      domes.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  const SurfaceFit fit = Level(18).on(domes);
  ASSERT_EQ(fit.pierced.size(), 2u);
  EXPECT_NEAR(fit.pierced[0].distance_mm, 3, 1e-4);
  EXPECT_NEAR(fit.pierced[0].place.x(), 25, 1e-6);
  EXPECT_NEAR(fit.pierced[1].distance_mm, 2, 1e-4);
  // Across: 2 mm below the top of a sphere of 20 mm, less what stands out by half a millimetre and less.
  EXPECT_NEAR(fit.pierced[1].size_mm, 2 * std::sqrt(20.0 * 20 - 18.5 * 18.5), 1);
}

TEST(SurfaceFit, MeasuresHowFarTheSheetStaysOff) {
  const TriangleMesh dome = hemisphere(30).mesh;
  const SurfaceFit fit = Level(31).on(dome);
  EXPECT_EQ(fit.penetration.max, 0);
  const double corner = std::sqrt(2 * 50.0 * 50 + 31 * 31) - 30;  // from the sheet's corner to the dome
  EXPECT_NEAR(fit.gap.max, corner, 1);
  EXPECT_GT(fit.gap.max, fit.gap.p99);
}

// Its corners touch the mold, its middle lies 3 mm above a hollow.
TEST(SurfaceFit, NamesTheHollowsThatTheSheetBridges) {
  TriangleMesh block;
  block.vertices = {{-50, -50, 20}, {50, -50, 20}, {50, 50, 20}, {-50, 50, 20}, {0, 0, 17}};
  block.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const SurfaceFit fit = Level(20).on(block);
  ASSERT_EQ(fit.bridged.size(), 1u);
  EXPECT_NEAR(fit.bridged[0].distance_mm, 3 * 50 / std::hypot(50, 3), 0.05);
  EXPECT_LT(fit.bridged[0].place.head<2>().norm(), 1);
  EXPECT_TRUE(fit.pierced.empty());
}

// One vertex of the sheet lies 6 mm deep in the mold: the mold above it is near the walls of this narrow dent.
TEST(SurfaceFit, CountsHowDeepTheSheetLiesInTheMold) {
  TriangleMesh block;
  block.vertices = {{-45, -45, 0},  {45, -45, 0},  {45, 45, 0},  {-45, 45, 0},
                    {-45, -45, 20}, {45, -45, 20}, {45, 45, 20}, {-45, 45, 20}};
  block.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4},
                     {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  Level level(20);
  level.formed[51 * 25 + 25].z() = 14;
  const SurfaceFit fit = level.on(block);
  EXPECT_GT(fit.penetration.max, 3);
  ASSERT_EQ(fit.pierced.size(), 1u);
  EXPECT_LT((fit.pierced[0].place - Eigen::Vector3d(0, 0, 14)).norm(), 2.5);
}

TEST(SurfaceFit, SaysThatASheetOnTheMoldFits) {
  TriangleMesh dome = hemisphere(30, 45, 90).mesh;  // the mold is its own sheet
  std::vector<Contact> contact(dome.vertices.size(), Contact::mold);
  const SurfaceFit fit = surface_fit(dome.triangles, dome.vertices, contact, dome);
  EXPECT_LT(fit.penetration.max, 0.021);
  EXPECT_LT(fit.gap.max, 1e-3);
}

TEST(SurfaceFit, DoesNotCountTheSheetThatTouchesNothing) {
  Level level(31);
  level.contact.assign(level.contact.size(), Contact::free);
  EXPECT_EQ(level.on(hemisphere(30).mesh).gap.max, 0);
}

}  // namespace
}  // namespace vacuform::surface_fit_test
