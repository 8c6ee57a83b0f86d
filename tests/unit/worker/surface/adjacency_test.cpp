#include "worker/surface/adjacency.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

// A square of two triangles, and a third one upright on their diagonal.
const std::vector<Triangle> square{{0, 1, 2}, {0, 2, 3}};
const std::vector<Triangle> fin{{0, 1, 2}, {0, 2, 3}, {0, 2, 4}};

TEST(Adjacency, FindsTheOtherSideOfAnEdge) {
  EXPECT_EQ(opposite_sides(square), (std::vector<int>{-1, 5, -1, -1, -1, 1}));
}

TEST(Adjacency, TakesAnEdgeOfThreeTrianglesForTheBorder) {
  EXPECT_EQ(opposite_sides(fin), std::vector<int>(9, -1));
}

TEST(Adjacency, FollowsTheBorderCounterClockwise) {
  EXPECT_EQ(border_loops(square), (std::vector<std::vector<int>>{{0, 1, 2, 3}}));
}

TEST(Adjacency, GivesTheTrianglesAroundAVertexInTheirOrder) {
  const VertexFans fans(square, 5);
  const auto around = [&](int v) { return std::vector<int>(fans.around(v).begin(), fans.around(v).end()); };
  EXPECT_EQ(around(0), (std::vector<int>{1, 2, 2, 3}));
  EXPECT_EQ(around(2), (std::vector<int>{0, 1, 3, 0}));
  EXPECT_TRUE(around(4).empty());
}

}  // namespace
}  // namespace vacuform
