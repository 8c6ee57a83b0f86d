#include "worker/coils/segments.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <map>
#include <set>

namespace vacuform {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A round chart of radius `radius`, seen from above at heights z(x, y), with triangles about `step` wide.
template <class Height>
Patch surface(double radius, double step, const Height& z) {
  Patch out;
  const int n = static_cast<int>(2 * radius / step);
  std::map<std::pair<int, int>, int> number;
  const auto vertex = [&](int i, int j) {
    const auto [it, fresh] = number.emplace(std::pair{i, j}, static_cast<int>(out.uv.size()));
    if (fresh) {
      const Vector2d p(i * step - radius, j * step - radius);
      out.uv.push_back(p), out.rest.push_back(p), out.inked.emplace_back(p.x(), p.y(), z(p.x(), p.y()));
    }
    return it->second;
  };
  const auto inside = [&](int i, int j) { return std::hypot(i * step - radius, j * step - radius) < radius; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      if (inside(i, j) && inside(i + 1, j) && inside(i, j + 1) && inside(i + 1, j + 1)) {
        const int a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
        out.triangles.push_back({a, b, c}), out.triangles.push_back({a, c, d});
      }
  return out;
}

double dome(double x, double y) { return std::sqrt(std::max(1.0, 60.0 * 60 - x * x - y * y)); }
double saddle(double x, double y) { return (x * x - y * y) / 60; }
double plane(double x, double y) { return 0.5 * x + 0.2 * y; }

double area(const Patch& patch) {
  double sum = 0;
  for (const Triangle& t : patch.triangles) {
    const auto p = [&](int k) {
      return patch.inked[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    sum += (p(1) - p(0)).cross(p(2) - p(0)).norm() / 2;
  }
  return sum;
}

TEST(Segments, StayBelowTheLimitAndCoverTheRegionOnce) {
  for (const auto& whole : {surface(55, 3, dome), surface(55, 3, saddle)}) {
    const auto cut = cut_into_segments(whole, 1, 1.05, Context{});
    ASSERT_TRUE(cut);
    EXPECT_GT(cut->patches.size(), 1u);
    EXPECT_LT(cut->patches.size(), 40u);
    std::size_t triangles = 0;
    double sum = 0;
    for (std::size_t i = 0; i < cut->patches.size(); ++i) {
      triangles += cut->patches[i].triangles.size();
      sum += area(cut->patches[i]);
      EXPECT_NEAR(patch_distortion(cut->patches[i], 1), cut->distortion[i], 1e-9);
      EXPECT_TRUE(cut->distortion[i] <= 1.05 || cut->patches[i].triangles.size() < 32) << i;
    }
    EXPECT_EQ(triangles, whole.triangles.size());
    EXPECT_NEAR(sum, area(whole), 1e-6);
  }
}

TEST(Segments, WhatCanBeFlattenedIsNotCut) {
  const auto cut = cut_into_segments(surface(40, 4, plane), 1, 1.02, Context{});
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->patches.size(), 1u);
  EXPECT_TRUE(cut->seams.empty());
  EXPECT_NEAR(cut->distortion[0], 1, 1e-3);
}

TEST(Segments, ALooserLimitNeedsFewer) {
  const Patch whole = surface(55, 3, dome);
  const auto tight = cut_into_segments(whole, 1, 1.03, Context{}),
             loose = cut_into_segments(whole, 1, 1.15, Context{});
  ASSERT_TRUE(tight && loose);
  EXPECT_GT(tight->patches.size(), loose->patches.size());
}

// Neighbours share the vertices of their seam on the sheet, and in the pattern they lie side by side.
TEST(Segments, MeetAtTheirSeams) {
  const auto cut = cut_into_segments(surface(55, 3, dome), 1, 1.06, Context{});
  ASSERT_TRUE(cut);
  ASSERT_FALSE(cut->seams.empty());
  for (const Seam& seam : cut->seams) {
    EXPECT_LT(seam.a, seam.b);
    std::set<std::pair<double, double>> of_a;
    for (const Vector2d& p : cut->patches[static_cast<std::size_t>(seam.a)].rest) of_a.emplace(p.x(), p.y());
    int shared = 0;
    for (const Vector2d& p : cut->patches[static_cast<std::size_t>(seam.b)].rest)
      shared += static_cast<int>(of_a.count({p.x(), p.y()}));
    EXPECT_GE(shared, 2);
    EXPECT_GT(seam.length_mm, 0);
    EXPECT_LE(seam.mean_jump_mm, seam.max_jump_mm);
    EXPECT_LT(seam.mean_jump_mm, 10);
  }
}

// Pattern millimetres at a scale of two: the same cut, in half the coordinates.
TEST(Segments, KnowTheScale) {
  Patch whole = surface(55, 3, dome);
  const auto plain = cut_into_segments(whole, 1, 1.06, Context{});
  for (Vector2d& uv : whole.uv) uv /= 2;
  const auto halved = cut_into_segments(whole, 2, 1.06, Context{});
  ASSERT_TRUE(plain && halved);
  ASSERT_EQ(plain->patches.size(), halved->patches.size());
  for (std::size_t i = 0; i < plain->patches.size(); ++i)
    for (std::size_t v = 0; v < plain->patches[i].uv.size(); ++v)
      EXPECT_LT((plain->patches[i].uv[v] - 2 * halved->patches[i].uv[v]).norm(), 1e-6);
}

TEST(Segments, CanBeCancelled) {
  Context context;
  context.cancel();
  const auto cut = cut_into_segments(surface(40, 4, dome), 1, 1.05, context);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().code, Code::cancelled);
}

}  // namespace
}  // namespace vacuform
