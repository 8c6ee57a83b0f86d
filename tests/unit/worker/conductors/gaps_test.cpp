#include "worker/conductors/gaps.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fixtures/coils_shapes.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

TEST(LoopPath, GoesRound) {
  const LoopPath path(DrawnLoop{.line = {{0, 0}, {10, 0}, {10, 5}, {0, 5}}});
  EXPECT_DOUBLE_EQ(path.length(), 30);
  EXPECT_LT((path.at(12) - Vector2d(10, 2)).norm(), 1e-12);
  EXPECT_LT((path.at(-1) - Vector2d(0, 1)).norm(), 1e-12);
  EXPECT_LT((path.at(61) - Vector2d(1, 0)).norm(), 1e-12);
  const Curve part = path.part(-3, 12);
  ASSERT_EQ(part.points.size(), 3u * 3 + 1);
  EXPECT_LT((part.points.front() - Vector2d(0, 3)).norm(), 1e-12);
  EXPECT_LT((part.points[3] - Vector2d(0, 0)).norm(), 1e-12);
  EXPECT_LT((part.points.back() - Vector2d(10, 2)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(apart_on_loop(1, 29, 30), 2);
  EXPECT_DOUBLE_EQ(apart_on_loop(-1, 45, 30), 14);
}

TEST(DrawnGaps, AreWhereTheTraceHasNoInk) {
  // A circle of 20 mm in two parts, open for 10 degrees about 0 and for 6 about 100.
  Shape parts;
  const auto arc = [](double from, double to) {
    std::vector<Vector2d> line;
    for (int i = 0; i <= 200; ++i) {
      const double a = (from + (to - from) * i / 200) * M_PI / 180;
      line.emplace_back(20 * std::cos(a), 20 * std::sin(a));
    }
    return straight_curve(line);
  };
  parts.curves = {arc(5, 97), arc(103, 355)};
  parts.stroke = Stroke{};
  parts.stroke->width_mm = 3;
  const Element whole = hand_made::ring("coil", {0, 0}, 20);
  const LoopPath path(*whole.loop);
  const double start = std::atan2(path.at(0).y(), path.at(0).x()), mm = 20 * M_PI / 180;
  const auto gaps = drawn_gaps(path, stroke_area(parts.curves, *parts.stroke, 0.002));
  ASSERT_EQ(gaps.size(), 2u);
  for (const auto& [middle, wide] : {std::pair(0.0, 10.0), {100.0, 6.0}}) {
    const double along = (middle * M_PI / 180 - start) * 20;
    EXPECT_TRUE(std::any_of(gaps.begin(), gaps.end(), [&](const Interval& gap) {
      return apart_on_loop(gap.middle(), along, path.length()) < 0.1 &&
             std::abs(gap.length() - wide * mm) < 0.1;
    })) << middle;
  }
  EXPECT_TRUE(drawn_gaps(path, stroke_area(whole.shapes[0].curves, *whole.shapes[0].stroke, 0.002)).empty());
}

TEST(PlacesForGaps, AreEquallySpacedFromThePort) {
  const auto places = places_for_gaps(100, 4, {2, 2}, 13, {});
  ASSERT_EQ(places.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(apart_on_loop(places[i], 13 + 25.0 * static_cast<double>(i), 100), 0, 1e-9);
}

TEST(PlacesForGaps, KeepClearOfWhatIsBlocked) {
  const std::vector<Interval> blocked{{10, 20}, {30, 44}, {95, 103}};
  for (const double port : {0.0, 15.0, 37.0, 99.0}) {
    const auto places = places_for_gaps(100, 3, {2, 2}, port, blocked);
    ASSERT_EQ(places.size(), 3u) << port;
    for (const double at : places)
      for (const Interval& b : blocked)
        EXPECT_GE(apart_on_loop(at, b.middle(), 100), b.length() / 2 + 2 - 1e-9) << port << " " << at;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < i; ++k) EXPECT_GE(apart_on_loop(places[i], places[k], 100), 4 - 1e-9);
  }
}

TEST(PlacesForGaps, AreFewerWhereThereIsNoRoom) {
  EXPECT_EQ(places_for_gaps(100, 3, {2, 2}, 0, {{0, 93}}).size(), 1u);
  EXPECT_TRUE(places_for_gaps(100, 3, {2, 2}, 0, {{10, 106.5}}).empty());
  EXPECT_EQ(places_for_gaps(100, 3, {2, 2}, 0, {{-5, 88}}).size(), 1u);
}

// A tenth of a wavelength is 469, 235 and 101 mm at 1.5, 3 and 7 T.
TEST(Gaps, AreAsManyAsTheFrequencyNeeds) {
  EXPECT_EQ(gaps_for_frequency(M_PI * 80, 3, 63.87), 2);  // the port and one to tune
  EXPECT_EQ(gaps_for_frequency(M_PI * 80, 3, 127.74), 2);
  EXPECT_EQ(gaps_for_frequency(M_PI * 80, 3, 298.04), 3);
  // 100 mm at 7 T: 1.21 pF in all (a table of closed forms), and four parts of a tenth of a wavelength.
  EXPECT_EQ(gaps_for_frequency(M_PI * 100, 5, 298.04), 4);
  // 500 mm at 3 T has 1.2 pF in all.
  EXPECT_EQ(gaps_for_frequency(M_PI * 500, 5, 127.74), 7);
  EXPECT_EQ(gaps_for_frequency(M_PI * 500, 5, 1000), 16);
}

}  // namespace
}  // namespace vacuform
