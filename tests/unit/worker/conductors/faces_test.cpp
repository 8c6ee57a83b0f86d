#include "worker/conductors/faces.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace vacuform {
namespace {

std::vector<Crossing> pairs(const std::vector<std::pair<int, int>>& list) {
  std::vector<Crossing> out;
  for (const auto& [a, b] : list)
    for (int i = 0; i < 2; ++i) out.push_back({a, b, 10.0 * i, 10.0 * i});
  return out;
}

std::size_t left(int count, const std::vector<Crossing>& crossings) {
  const auto faces = choose_faces(count, crossings);
  EXPECT_EQ(faces.size(), static_cast<std::size_t>(count));
  return crossings_on(0, faces, crossings).size() + crossings_on(1, faces, crossings).size();
}

TEST(Faces, SufficeForARow) {
  EXPECT_EQ(left(5, pairs({{0, 1}, {1, 2}, {2, 3}, {3, 4}})), 0u);
  EXPECT_EQ(choose_faces(3, pairs({{0, 1}, {1, 2}})), (std::vector<int>{0, 1, 0}));
}

TEST(Faces, SufficeForAnEvenCircleAndNotForAnOddOne) {
  EXPECT_EQ(left(6, pairs({{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {0, 5}})), 0u);
  EXPECT_EQ(left(5, pairs({{0, 1}, {1, 2}, {2, 3}, {3, 4}, {0, 4}})), 2u);
}

// Six around one: of every three that all cross, two share a face. At least four of the twelve pairs stay, since each
// pair is in at most two of the six triangles, less for the outer ones.
TEST(Faces, OfSevenRingsLeaveAsFewAsCanBe) {
  std::vector<std::pair<int, int>> list;
  for (int i = 1; i <= 6; ++i) list.push_back({0, i}), list.push_back(std::minmax(i, i % 6 + 1));
  // With alternating outer rings the inner one shares a face with three of them.
  EXPECT_EQ(left(7, pairs(list)), 6u);
}

TEST(Faces, LeaveALoopWithoutNeighboursWhereItWasDrawn) {
  EXPECT_EQ(choose_faces(3, pairs({{1, 2}})), (std::vector<int>{0, 0, 1}));
}

TEST(Faces, DoNotPartALoopFromItself) { EXPECT_EQ(left(1, {{0, 0, 1, 2}}), 1u); }

}  // namespace
}  // namespace vacuform
