#include "worker/surface/planar_triangles.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/numerics/plane.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

double area_of(const PlanarTriangles& of) {
  double out = 0;
  for (const auto& [a, b, c] : of.triangles) {
    const double twice = cross(Vector2d(of.points[b] - of.points[a]), Vector2d(of.points[c] - of.points[a]));
    EXPECT_GT(twice, 0);
    out += twice / 2;
  }
  return out;
}

std::vector<Vector2d> square_at(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

TEST(PlanarTriangles, CoverARingWithItsHoleAndAnIslandInIt) {
  const PlanarTriangles all = triangulate({square_at(0, 0, 10), square_at(2, 3, 5), square_at(3, 4, 1)});
  EXPECT_TRUE(all.simple);
  EXPECT_NEAR(area_of(all), 100 - 25 + 1, 1e-9);
  EXPECT_EQ(all.points.size(), 12u);
}

TEST(PlanarTriangles, CoverRingsThatTouchAtAPoint) {
  const PlanarTriangles two = triangulate({square_at(0, 0, 2), square_at(2, 2, 3)});
  EXPECT_FALSE(two.simple);
  EXPECT_NEAR(area_of(two), 4 + 9, 1e-9);
}

TEST(PlanarTriangles, AddPointsWhereSidesCross) {
  const PlanarTriangles bow = triangulate({{{0, 0}, {4, 4}, {4, 0}, {0, 4}}});
  EXPECT_FALSE(bow.simple);
  EXPECT_EQ(bow.points.size(), 5u);
  EXPECT_NEAR(area_of(bow), 8, 1e-9);
}

TEST(PlanarTriangles, AreNoneForALine) {
  EXPECT_TRUE(triangulate({{{0, 0}, {1, 1}, {2, 2}}}).triangles.empty());
  EXPECT_TRUE(triangulate({}).triangles.empty());
}

}  // namespace
}  // namespace vacuform
