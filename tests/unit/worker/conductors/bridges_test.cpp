#include "worker/conductors/bridges.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/pattern/drawing.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

// A flat part: the drawing as it is, times `scale`.
Patch flat_patch(double scale) {
  Patch out;
  out.uv = {{-200, -200}, {200, -200}, {200, 200}, {-200, 200}};
  for (const Vector2d& p : out.uv) {
    out.rest.push_back(p);
    out.inked.emplace_back(scale * p.x(), scale * p.y(), 0);
  }
  out.triangles = {{0, 1, 2}, {0, 2, 3}};
  return out;
}

// A long rectangle whose lower side runs through (x, y) at `degrees`, 60 mm to each side; along = 60 there.
DrawnLoop bar(const Vector2d& at, double degrees) {
  const double a = degrees * M_PI / 180;
  const Vector2d u(std::cos(a), std::sin(a)), v(-u.y(), u.x());
  return {.line = {at - 60 * u, at + 60 * u, at + 60 * u + 80 * v, at - 60 * u + 80 * v}};
}

// A crossing of a trace of 3 mm with one of 2 mm that is drawn at 0.8.
struct TwoBars {
  Patch one = flat_patch(1), other = flat_patch(0.8);
  Trace a, b;
  Crossing crossing{.a = 0, .b = 1, .along_a = 60, .along_b = 60};

  explicit TwoBars(double degrees) : a(bar({0, 0}, 0), one, 3, 1), b(bar({0, 0}, degrees), other, 2, 0.8) {}
  Bridge bridge(const BridgeSizes& sizes) {
    const Bridges chosen = choose_bridges(
        {crossing}, [&](int e) -> const Trace& { return e == 0 ? a : b; }, sizes);
    EXPECT_EQ(chosen.bridges.size(), 1u);
    EXPECT_EQ(chosen.crowded, 0);
    return chosen.bridges.at(0);
  }
};

// Straight across: half of the other's width and what the sizes ask for.
TEST(Bridges, ReachAsFarAsTheSizesSay) {
  const Bridge b = TwoBars(90).bridge({.margin = 1, .overlap = 2, .clearance = 0.5});
  EXPECT_EQ(b.over(), 1);
  EXPECT_EQ(b.under(), 0);
  EXPECT_DOUBLE_EQ(b.along_over(), 60);
  EXPECT_NEAR(b.cut, (1.5 + 0.55) / 0.8, 0.1);
  EXPECT_NEAR(b.reach, (1.5 + 1 + 2) / 0.8, 0.1);
  EXPECT_NEAR(b.patch, 1 + 1, 0.1);
}

// At 30 degrees a trace of 3 mm is 6 mm long across the other, and its edges lie 1 mm / tan 30 apart on one of 2 mm.
TEST(Bridges, ReachFartherAtAnAngle) {
  const Bridge b = TwoBars(30).bridge({.margin = 1, .overlap = 2, .clearance = 0.5});
  EXPECT_NEAR(b.cut, ((1.5 + 0.55) * 2 + 1 * std::sqrt(3.0)) / 0.8, 0.1);
  EXPECT_NEAR(b.patch, (1 + 1) * 2 + 1.5 * std::sqrt(3.0), 0.1);
}

// Two crossings of a loop 5 mm apart: a bridge and a patch need 3.5 + 2 mm. The loop must be above at both, or below.
TEST(Bridges, DoNotEndOnPatches) {
  const Patch part = flat_patch(1);
  const Trace a(bar({0, 0}, 0), part, 3, 1), b(bar({-2.5, 0}, 90), part, 3, 1),
      c(bar({2.5, 0}, 90), part, 3, 1);
  const auto trace_of = [&](int e) -> const Trace& { return e == 0 ? a : e == 1 ? b : c; };
  std::vector<Crossing> crossings{{.a = 0, .b = 1, .along_a = 57.5, .along_b = 60},
                                  {.a = 0, .b = 2, .along_a = 62.5, .along_b = 60}};
  const Bridges chosen = choose_bridges(crossings, trace_of, {});
  EXPECT_EQ(chosen.crowded, 0);
  EXPECT_EQ(chosen.bridges[0].over() == 0, chosen.bridges[1].over() == 0);
  // Where three loops cross in one place none of the choices helps all.
  crossings.push_back({.a = 1, .b = 2, .along_a = 60, .along_b = 60});
  EXPECT_EQ(choose_bridges(crossings, trace_of, {}).crowded, 1);
}

}  // namespace
}  // namespace vacuform
