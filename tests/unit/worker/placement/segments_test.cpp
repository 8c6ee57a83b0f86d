#include "worker/placement/segments.hpp"

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
    const auto cut = cut_into_segments(whole, 1, 1.05, {}, Context{});
    ASSERT_TRUE(cut);
    EXPECT_GT(cut->parts.size(), 1u);
    EXPECT_LT(cut->parts.size(), 40u);
    std::size_t triangles = 0;
    double sum = 0;
    for (std::size_t i = 0; i < cut->parts.size(); ++i) {
      triangles += cut->parts[i].patch.triangles.size();
      sum += area(cut->parts[i].patch);
      EXPECT_NEAR(patch_distortion(cut->parts[i].patch, 1), cut->parts[i].distortion, 1e-9);
      EXPECT_TRUE(cut->parts[i].distortion <= 1.05 || cut->parts[i].patch.triangles.size() < 32) << i;
    }
    EXPECT_EQ(triangles, whole.triangles.size());
    EXPECT_NEAR(sum, area(whole), 1e-6);
  }
}

TEST(Segments, DoNotCutASurfaceThatFlattens) {
  const auto cut = cut_into_segments(surface(40, 4, plane), 1, 1.02, {}, Context{});
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->parts.size(), 1u);
  EXPECT_TRUE(cut->seams.empty());
  EXPECT_NEAR(cut->parts[0].distortion, 1, 1e-3);
}

TEST(Segments, ALooserLimitNeedsFewer) {
  const Patch whole = surface(55, 3, dome);
  const auto tight = cut_into_segments(whole, 1, 1.03, {}, Context{}),
             loose = cut_into_segments(whole, 1, 1.15, {}, Context{});
  ASSERT_TRUE(tight && loose);
  EXPECT_GT(tight->parts.size(), loose->parts.size());
}

// Neighbours share the vertices of their seam on the sheet, and in the pattern they lie side by side.
TEST(Segments, MeetAtTheirSeams) {
  const auto cut = cut_into_segments(surface(55, 3, dome), 1, 1.06, {}, Context{});
  ASSERT_TRUE(cut);
  ASSERT_FALSE(cut->seams.empty());
  for (const Seam& seam : cut->seams) {
    EXPECT_LT(seam.a, seam.b);
    std::set<std::pair<double, double>> of_a;
    for (const Vector2d& p : cut->parts[static_cast<std::size_t>(seam.a)].patch.rest)
      of_a.emplace(p.x(), p.y());
    int shared = 0;
    for (const Vector2d& p : cut->parts[static_cast<std::size_t>(seam.b)].patch.rest)
      shared += static_cast<int>(of_a.count({p.x(), p.y()}));
    EXPECT_GE(shared, 2);
    EXPECT_GT(seam.length_mm, 0);
    EXPECT_LE(seam.mean_jump_mm, seam.max_jump_mm);
    EXPECT_LT(seam.mean_jump_mm, 10);
  }
}

// Edges of the chart where x is `x`, between the rows y = low and y = high.
std::vector<Edge> straight_cut(const Patch& chart, double x, double low, double high) {
  std::set<Edge> edges;
  for (const Triangle& t : chart.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const auto on = [&](int v) {
        const Vector2d& p = chart.uv[static_cast<std::size_t>(v)];
        return std::abs(p.x() - x) < 1e-9 && p.y() > low - 1e-9 && p.y() < high + 1e-9;
      };
      if (on(a) && on(b)) edges.insert(std::minmax(a, b));
    }
  return {edges.begin(), edges.end()};
}

// A cut from rim to rim parts the region, also where it could stay whole, and nothing else is cut.
TEST(Segments, EndAtAGivenCut) {
  const Patch whole = surface(40, 4, plane);
  const auto cut = cut_into_segments(whole, 1, 1.02, straight_cut(whole, 4, -100, 100), Context{});
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->parts.size(), 2u);
  EXPECT_TRUE(cut->cuts_sufficed);
  ASSERT_EQ(cut->seams.size(), 1u);
  EXPECT_LT(cut->seams[0].max_jump_mm, 0.2);
  for (const Segment& part : cut->parts) {
    const Triangle& first = part.patch.triangles[0];
    const auto x_of = [&](std::size_t k) { return part.patch.rest[static_cast<std::size_t>(first[k])].x(); };
    const bool left = x_of(0) + x_of(1) + x_of(2) < 3 * 4;
    for (const Triangle& t : part.patch.triangles)
      for (const int v : t) {
        const double x = part.patch.rest[static_cast<std::size_t>(v)].x();
        EXPECT_TRUE(left ? x < 4 + 1e-9 : x > 4 - 1e-9);
      }
  }
}

// A slit towards the middle of a dome lets it open: less distortion, still one piece, and the slit is told.
TEST(Segments, ASlitOpens) {
  const Patch whole = surface(40, 4, dome);
  const auto closed = cut_into_segments(whole, 1, 5, {}, Context{}),
             open = cut_into_segments(whole, 1, 5, straight_cut(whole, 0, -100, 0), Context{});
  ASSERT_TRUE(closed && open);
  ASSERT_EQ(open->parts.size(), 1u);
  EXPECT_LT(open->parts[0].distortion, closed->parts[0].distortion);
  ASSERT_EQ(open->seams.size(), 1u);
  EXPECT_EQ(open->seams[0].a, open->seams[0].b);
  EXPECT_GT(open->seams[0].max_jump_mm, 1);
  // Each vertex of the slit but its inner end is there twice.
  EXPECT_EQ(open->parts[0].patch.uv.size(), whole.uv.size() + open->seams[0].edges.size());
}

TEST(Segments, SayWhereGivenCutsWereNotEnough) {
  const Patch whole = surface(55, 3, dome);
  const auto cut = cut_into_segments(whole, 1, 1.05, straight_cut(whole, 2, -100, 100), Context{});
  ASSERT_TRUE(cut);
  EXPECT_GT(cut->parts.size(), 2u);
  EXPECT_FALSE(cut->cuts_sufficed);
}

// Pattern millimetres at a scale of two: the same cut, in half the coordinates.
TEST(Segments, KnowTheScale) {
  Patch whole = surface(55, 3, dome);
  const auto plain = cut_into_segments(whole, 1, 1.06, {}, Context{});
  for (Vector2d& uv : whole.uv) uv /= 2;
  const auto halved = cut_into_segments(whole, 2, 1.06, {}, Context{});
  ASSERT_TRUE(plain && halved);
  ASSERT_EQ(plain->parts.size(), halved->parts.size());
  for (std::size_t i = 0; i < plain->parts.size(); ++i)
    for (std::size_t v = 0; v < plain->parts[i].patch.uv.size(); ++v)
      EXPECT_LT((plain->parts[i].patch.uv[v] - 2 * halved->parts[i].patch.uv[v]).norm(), 1e-6);
}

TEST(Segments, CanBeCancelled) {
  Context context;
  context.cancel();
  const auto cut = cut_into_segments(surface(40, 4, dome), 1, 1.05, {}, context);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().code, Code::cancelled);
}

}  // namespace
}  // namespace vacuform
