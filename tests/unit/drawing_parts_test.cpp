#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/drawing_files.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/ink_parts.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

// 60 x 40 mm at 10 pixels a millimetre: a ring, a square with a gray edge, a speck.
Pattern pattern() {
  const auto gray = [](int i, int j) {
    const Vector2d p((i + 0.5) / 10 - 30, 20 - (j + 0.5) / 10);
    const double ring = std::abs((p - Vector2d(-12, 4)).norm() - 10) - 1.5;
    const double square = (p - Vector2d(18, -6)).cwiseAbs().maxCoeff() - 5;
    const double speck = (p - Vector2d(18, 14)).norm() - 0.4;
    const double off = std::min({ring, square, speck});
    return static_cast<int>(255 * std::clamp(0.5 + off / 0.4, 0.0, 1.0));
  };
  auto read = Pattern::read(gray_png(600, 400, 10000, gray), "parts.png", {}, 300);
  if (!read) throw std::runtime_error(read.error().text());
  return std::move(*read);
}

TEST(InkParts, AreTheConnectedInkWithItsOutlines) {
  const InkParts parts(pattern());
  const auto& elements = parts.drawing().elements;
  ASSERT_EQ(elements.size(), 2u);
  EXPECT_EQ(elements[0].id, "ink-1");
  EXPECT_LT((elements[0].centre - Vector2d(-12, 4)).norm(), 0.01);
  EXPECT_EQ(elements[1].id, "ink-2");
  EXPECT_LT((elements[1].centre - Vector2d(18, -6)).norm(), 0.01);
  ASSERT_EQ(elements[0].shapes[0].curves.size(), 2u);
  EXPECT_TRUE(elements[0].shapes[0].curves[0].closed);
  EXPECT_NEAR(square_mm(fill_area(elements[0].shapes[0].curves, true, 1e-3)), M_PI * 2 * 10 * 3, 0.3);
  EXPECT_NEAR(square_mm(fill_area(elements[1].shapes[0].curves, true, 1e-3)), 100, 0.3);
  for (const Vector2d& p : elements[0].shapes[0].curves[0].points)
    EXPECT_NEAR(std::abs((p - Vector2d(-12, 4)).norm() - 10), 1.5, 0.03);
}

TEST(InkParts, TakeTheirSmoothedEdgesWithThem) {
  const InkParts parts(pattern());
  EXPECT_EQ(parts.part_at({-2, 4}), 0);
  EXPECT_EQ(parts.part_at({-0.2, 4}), 0);
  EXPECT_EQ(parts.part_at({18, -6}), 1);
  EXPECT_EQ(parts.part_at({18, -0.5}), 1);
  EXPECT_EQ(parts.part_at({-12, 4}), -1);
  EXPECT_EQ(parts.part_at({18, 14}), -1);
  EXPECT_EQ(parts.part_at({1000, 0}), -1);
  EXPECT_EQ(parts.part_at({NAN, 0}), -1);
}

TEST(InkParts, ArePlacedWhereTheyMayBeAnArray) {
  EXPECT_FALSE(parts_to_place(pattern(), PatternPlacement::chart));
  EXPECT_TRUE(parts_to_place(pattern(), PatternPlacement::automatic));
  const auto one = [](int side) {
    return std::move(
        *Pattern::read(gray_png(side, side, 1000, [](int, int) { return 0; }), "one.png", {}, 300));
  };
  EXPECT_FALSE(parts_to_place(one(50), PatternPlacement::automatic));
  EXPECT_TRUE(parts_to_place(one(50), PatternPlacement::elements));
}

}  // namespace
}  // namespace vacuform
