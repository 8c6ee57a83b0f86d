#include "worker/coils/placement.hpp"

#include <gtest/gtest.h>

#include "tests/unit/hand_made_sheets.hpp"

namespace vacuform {
namespace {

TEST(Placement, OnTheChartTurnsMovesAndScales) {
  FormedSheet sheet;
  sheet.triangles = {{0, 1, 2}, {1, 3, 2}};
  sheet.rest = {{0, 0}, {10, 0}, {0, 10}, {10, 10}};
  Flattening flattening;
  flattening.triangles = {1};
  flattening.chart = {{NAN, NAN}, {12, 0}, {0, 12}, {12, 12}};
  flattening.inked = {{0, 0, 5}, {10, 0, 5}, {0, 10, 5}, {10, 10, 5}};
  Settings settings;
  settings.pattern.offset_mm = {2, 0};
  settings.pattern.rotate_deg = 90;
  settings.pattern.scale = 2;
  const auto placed = place(sheet, flattening, nullptr, settings, Context());
  ASSERT_TRUE(placed);
  const Patch& chart = placed->chart;
  ASSERT_EQ(chart.triangles.size(), 1u);
  ASSERT_EQ(chart.uv.size(), 3u);
  EXPECT_TRUE(chart.rest[0].isApprox(Eigen::Vector2d(10, 0)));
  // The chart's (12, 0) is 10 mm to the right of the drawing's centre; the drawing was turned left and doubled.
  EXPECT_LT((chart.uv[0] - Eigen::Vector2d(0, -5)).norm(), 1e-12);
  EXPECT_TRUE(placed->elements.empty());
}

}  // namespace
}  // namespace vacuform
