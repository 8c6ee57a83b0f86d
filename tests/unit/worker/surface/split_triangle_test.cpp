// A triangle with vertices in the middle of any of its sides falls into pieces that cover it and use every vertex.
#include "worker/surface/split_triangle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <set>

#include "worker/numerics/plane.hpp"

namespace vacuform {
namespace {

TEST(SplitTriangle, IsCoveredByItsPieces) {
  const std::array<Eigen::Vector2d, 6> places{
      Eigen::Vector2d(0, 0), {4, 0}, {1, 3}, {2, 0}, {2.5, 1.5}, {0.5, 1.5}};
  for (int split = 0; split < 8; ++split) {
    std::array<int, 3> middles{};
    std::set<int> expected{0, 1, 2}, used;
    for (int k = 0; k < 3; ++k) {
      middles[k] = split >> k & 1 ? 3 + k : -1;
      if (middles[k] >= 0) expected.insert(middles[k]);
    }
    const auto pieces = pieces_of({0, 1, 2}, middles);
    EXPECT_EQ(pieces.size(), expected.size() - 2) << split;
    double area = 0;
    std::set<std::pair<int, int>> sides;
    for (const Triangle& t : pieces) {
      const double piece = cross(places[t[1]] - places[t[0]], places[t[2]] - places[t[0]]) / 2;
      EXPECT_GT(piece, 0) << split;
      area += piece;
      for (int k = 0; k < 3; ++k) used.insert(t[k]), sides.insert({t[k], t[(k + 1) % 3]});
    }
    EXPECT_DOUBLE_EQ(area, 6) << split;
    EXPECT_EQ(used, expected) << split;
    // The neighbour across each side sees it whole, or in two halves.
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      EXPECT_EQ(sides.count({k, next}), middles[k] < 0) << split;
      if (middles[k] >= 0) {
        EXPECT_TRUE(sides.count({k, middles[k]}) && sides.count({middles[k], next})) << split;
      }
    }
  }
}

}  // namespace
}  // namespace vacuform
