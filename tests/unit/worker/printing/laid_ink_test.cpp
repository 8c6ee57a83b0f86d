#include "worker/printing/laid_ink.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "tests/unit/worker/printing/painted_rows.hpp"
#include "worker/printing/mold_outline.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using hand_made::Sample;

// One black rectangle.
auto rectangle(const PrintGrid& grid, const Vector2d& low, const Vector2d& high) {
  return PaintedRows(grid, [=](const Vector2d& p) {
    return (p.array() > low.array()).all() && (p.array() < high.array()).all();
  });
}
// The right half of the sheet is stretched to three times its width and lies off the chart.
TEST(LaidInk, CountsWhatLiesOnTheHeadByItsFormedArea) {
  Sample x = hand_made::flat(100, 10);
  for (Vector3d& p : x.sheet.formed)
    if (p.x() > 0) p.x() *= 3;
  std::erase_if(x.flattening.triangles, [&](int t) {
    const Triangle& c = x.sheet.triangles[static_cast<std::size_t>(t)];
    return std::any_of(c.begin(), c.end(),
                       [&](int v) { return x.sheet.rest[static_cast<std::size_t>(v)].x() > 0; });
  });
  const PrintGrid grid = LaidInk::grid_of(100, 100);
  const auto share = [&](double left, double right) {
    return LaidInk(rectangle(grid, {left, -10}, {right, 10}), grid).share_on(hand_made::Charted(x));
  };
  EXPECT_NEAR(share(-20, 20), 0.25, 0.005);
  EXPECT_EQ(share(-30, -5), 1);
  EXPECT_EQ(share(5, 30), 0);
}

TEST(LaidInk, KnowsWhatIsNearIt) {
  const PrintGrid grid = LaidInk::grid_of(100, 100);
  const LaidInk ink(rectangle(grid, {0, 0}, {10, 10}), grid);
  EXPECT_TRUE(ink.any_near({-1.8, 5}, 2));
  EXPECT_FALSE(ink.any_near({-2.3, 5}, 2));
  EXPECT_FALSE(ink.any_near({500, 5}, 2));
}

// The border of the cells of 1.5 mm whose middles lie in a circle of 50 mm.
std::vector<Vector2d> steps_of_a_circle() {
  constexpr double cell = 1.5, radius = 50;
  std::vector<Vector2d> quarter;
  for (int j = 0; (j + 0.5) * cell < radius; ++j) {
    const double y = (j + 0.5) * cell, x = cell * std::round(std::sqrt(radius * radius - y * y) / cell);
    quarter.emplace_back(x, j * cell);
    quarter.emplace_back(x, (j + 1) * cell);
  }
  std::vector<Vector2d> ring;
  for (int turn = 0; turn < 4; ++turn)
    for (const Vector2d& p : quarter) {
      const Vector2d q = Eigen::Rotation2Dd(turn * M_PI / 2) * p;
      if (ring.empty() || (ring.back() - q).norm() > 1e-6) ring.push_back(q);
    }
  return ring;
}

TEST(MoldOutline, IsASmoothCurveAndNotTheStepsOfTheGrid) {
  const PrintGrid grid = LaidInk::grid_of(200, 200);
  const LaidInk none(rectangle(grid, {90, 90}, {95, 95}), grid);
  const auto lines = mold_outline({steps_of_a_circle()}, 1.5, none);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].closed && lines[0].dashed);
  const auto& p = lines[0].points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_NEAR(p[i].norm(), 50, 0.5);
    const Vector2d a = p[(i + 1) % p.size()] - p[i], b = p[(i + 2) % p.size()] - p[(i + 1) % p.size()];
    EXPECT_LT(std::acos(std::min(1.0, a.normalized().dot(b.normalized()))), 12 * M_PI / 180)
        << p[i].transpose();
  }
}

TEST(MoldOutline, StopsBesideTheInkAndIsDrawnEverywhereElse) {
  const PrintGrid grid = LaidInk::grid_of(200, 200);
  const LaidInk ink(rectangle(grid, {40, -10}, {60, 10}), grid);
  const auto lines = mold_outline({steps_of_a_circle()}, 1.5, ink);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_FALSE(lines[0].closed);
  double length = 0;
  const auto& p = lines[0].points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_FALSE(ink.any_near(p[i], 1.9));
    if (i > 0) length += (p[i] - p[i - 1]).norm();
  }
  EXPECT_NEAR(length, 2 * M_PI * 50 - 2 * 12.2, 4);
}

}  // namespace
}  // namespace vacuform
