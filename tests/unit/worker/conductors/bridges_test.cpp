#include "worker/conductors/bridges.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace vacuform {
namespace {

const std::vector<TraceOnPart> traces{{3, 1, 120}, {2, 0.8, 120}};

// Straight across: half of the other's width and what the sizes ask for.
TEST(Bridges, ReachAsFarAsTheSizesSay) {
  const Crossing crossing{.a = 0, .b = 1, .along_a = 10, .along_b = 20};
  const BridgeSizes sizes{.margin = 1, .overlap = 2, .clearance = 0.5};
  const Bridges chosen = choose_bridges({crossing}, traces, sizes);
  ASSERT_EQ(chosen.bridges.size(), 1u);
  EXPECT_EQ(chosen.crowded, 0);
  const Bridge& b = chosen.bridges[0];
  EXPECT_EQ(b.over(), 1);
  EXPECT_EQ(b.under(), 0);
  EXPECT_DOUBLE_EQ(b.along_over(), 20);
  EXPECT_NEAR(b.cut, (1.5 + 0.5) / 0.8, 1e-12);
  EXPECT_NEAR(b.reach, (1.5 + 1 + 2) / 0.8, 1e-12);
  EXPECT_NEAR(b.patch, 1 + 1, 1e-12);
}

// At 30 degrees a trace of 3 mm is 6 mm long across the other, and its edges lie 1 mm / tan 30 apart on one of 2 mm.
TEST(Bridges, ReachFartherAtAnAngle) {
  const Crossing crossing{.a = 0, .b = 1, .sine = 0.5};
  const Bridges chosen = choose_bridges({crossing}, traces, {.margin = 1, .overlap = 2, .clearance = 0.5});
  EXPECT_NEAR(chosen.bridges[0].cut, ((1.5 + 0.5) * 2 + 1 * std::sqrt(3.0)) / 0.8, 1e-12);
}

// Two crossings of a loop 6 mm apart: a bridge and a patch need 4.5 + 2.5 mm. The loop must be above at both, or below.
TEST(Bridges, DoNotEndOnPatches) {
  const std::vector<TraceOnPart> three(3, {3, 1, 120});
  std::vector<Crossing> crossings{{.a = 0, .b = 1, .along_a = 117, .along_b = 50},
                                  {.a = 0, .b = 2, .along_a = 3, .along_b = 50},
                                  {.a = 1, .b = 2, .along_a = 100, .along_b = 100}};
  const Bridges chosen = choose_bridges(crossings, three, {});
  EXPECT_EQ(chosen.crowded, 0);
  EXPECT_EQ(chosen.bridges[0].over() == 0, chosen.bridges[1].over() == 0);
  // Where the three loops cross in one place none of the choices helps all.
  for (Crossing& c : crossings) c.along_a = c.along_b = 50;
  EXPECT_EQ(choose_bridges(crossings, three, {}).crowded, 1);
}

}  // namespace
}  // namespace vacuform
