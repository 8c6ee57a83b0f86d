#include "worker/forming/sheet_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace vacuform::sheet_grid_test {
namespace {

double area(const SheetGrid& grid, const Triangle& t) {
  const Eigen::Vector2d a = grid.rest[t[1]] - grid.rest[t[0]], b = grid.rest[t[2]] - grid.rest[t[0]];
  return 0.5 * (a.x() * b.y() - a.y() * b.x());
}

TEST(SheetGrid, FollowsARectangularWindow) {
  SheetSettings sheet;
  sheet.width_mm = 310, sheet.height_mm = 205, sheet.resolution_mm = 7;
  MachineSettings machine;
  machine.window_width_mm = 281, machine.window_height_mm = 173;
  const auto grid = make_sheet_grid(sheet, machine);
  double total = 0, inside = 0;
  for (const Triangle& t : grid.triangles) {
    ASSERT_GT(area(grid, t), 0);
    total += area(grid, t);
    const Eigen::Vector2d c = (grid.rest[t[0]] + grid.rest[t[1]] + grid.rest[t[2]]) / 3;
    if (std::abs(c.x()) < 140.5 && std::abs(c.y()) < 86.5) inside += area(grid, t);
  }
  EXPECT_NEAR(total, 310 * 205, 1e-6);
  EXPECT_NEAR(inside, 281 * 173, 1e-6);  // no triangle lies across the window's edge
  for (std::size_t i = 0; i < grid.rest.size(); ++i)
    EXPECT_EQ(grid.clamped[i] != 0,
              std::abs(grid.rest[i].x()) > 140.5 - 1e-9 || std::abs(grid.rest[i].y()) > 86.5 - 1e-9);
}

// Where a circle cuts a grid slivers arise easily: none may, at any size.
TEST(SheetGrid, CircularWindowsLeaveNoTriangleTurnedOrLost) {
  MachineSettings machine;
  machine.window = WindowShape::circle;
  for (double diameter = 60; diameter < 300; diameter += 7.3)
    for (const double resolution : {2.0, 2.7, 3.0, 4.0, 5.0, 8.0}) {
      SheetSettings sheet;
      sheet.resolution_mm = resolution;
      machine.window_width_mm = diameter;
      const auto grid = make_sheet_grid(sheet, machine);
      double total = 0, least = 1e9;
      for (const Triangle& t : grid.triangles) total += area(grid, t), least = std::min(least, area(grid, t));
      EXPECT_NEAR(total, 90000, 1e-6) << diameter << " " << resolution;
      EXPECT_GT(least, 0.01 * resolution * resolution) << diameter << " " << resolution;
    }
}

TEST(SheetGrid, EliminationOrderIsAPermutation) {
  auto order = make_sheet_grid({}, {}).elimination_order;
  std::sort(order.begin(), order.end());
  for (int i = 0; i < static_cast<int>(order.size()); ++i) ASSERT_EQ(order[i], i);
}

TEST(SheetGrid, PartsOfTheDissectionCoverTheOrder) {
  const auto grid = make_sheet_grid({}, {});
  int at = 0;
  for (const auto& part : grid.dissection.parts) {
    EXPECT_EQ(part.begin, at);
    at = part.end;
  }
  EXPECT_EQ(at, static_cast<int>(grid.elimination_order.size()));
}

}  // namespace
}  // namespace vacuform::sheet_grid_test
