#include "worker/surface/scan_lines.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "worker/stage/parallel.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

TEST(ScanLines, TrianglesThatShareEdgesOwnEverySampleOnce) {
  // A grid of random, skewed triangles about a sample large; some vertices lie on samples' centres.
  constexpr int n = 40, size = 60;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.35, 0.35);
  std::vector<Vector2d> points;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const bool border = i == 0 || j == 0 || i == n || j == n;
      Vector2d p(size * static_cast<double>(i) / n, size * static_cast<double>(j) / n);
      if (!border && (i + j) % 4 != 0) p += Vector2d(shift(random), shift(random));
      points.push_back(p);
    }
  std::vector<int> owners(size * size, 0);
  const auto fill = [&](int a, int b, int c) {
    const auto at = [&](int i) { return points[static_cast<std::size_t>(i)]; };
    scan_triangle({at(a), at(b), at(c)}, size, 0, size, [&](int row, int begin, int end) {
      for (int x = begin; x < end; ++x) ++owners[static_cast<std::size_t>(row * size + x)];
    });
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      // Both turns, corners in any order: ownership must not depend on them.
      (i + j) % 2 ? (fill(a, b, d), fill(c, a, d)) : (fill(b, c, a), fill(b, c, d));
    }
  for (std::size_t i = 0; i < owners.size(); ++i) EXPECT_EQ(owners[i], 1) << i % size << ", " << i / size;
}

TEST(ScanLines, StaysInsideTheGridAndRows) {
  int rows = 0;
  scan_triangle({Vector2d(-1e12, -1e12), Vector2d(1e12, -1e12), Vector2d(0, 1e12)}, 10, 3, 7,
                [&](int row, int begin, int end) {
                  EXPECT_GE(row, 3);
                  EXPECT_LT(row, 7);
                  EXPECT_EQ(begin, 0);
                  EXPECT_EQ(end, 10);
                  ++rows;
                });
  EXPECT_EQ(rows, 4);
}

TEST(ScanLines, DegenerateTrianglesOwnNothing) {
  const auto never = [](int, int, int) { FAIL(); };
  scan_triangle({Vector2d(1, 1), Vector2d(1, 1), Vector2d(1, 1)}, 10, 0, 10, never);
  scan_triangle({Vector2d(1, 1), Vector2d(5, 5), Vector2d(9, 9)}, 10, 0, 10, never);
  scan_triangle({Vector2d(NAN, 1), Vector2d(5, 5), Vector2d(9, 2)}, 10, 0, 10, never);
  scan_triangle({Vector2d(INFINITY, 1), Vector2d(5, 5), Vector2d(9, 2)}, 10, 0, 10, never);
}

TEST(RowsInParallel, CoversEveryRowOnceAndThrowsOn) {
  std::vector<int> seen(1000, 0);
  in_parallel(3, 997, [&](int first, int last) {
    for (int i = first; i < last; ++i) ++seen[static_cast<std::size_t>(i)];
  });
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], i >= 3 && i < 997);
  in_parallel(5, 5, [](int first, int last) { EXPECT_EQ(first, last); });
  EXPECT_THROW(in_parallel(0, 9, [](int, int) { throw std::runtime_error("x"); }), std::runtime_error);
}

}  // namespace
}  // namespace vacuform
