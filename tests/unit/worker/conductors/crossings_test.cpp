#include "worker/conductors/crossings.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/conductors/loop_path.hpp"

namespace vacuform {
namespace {

using namespace hand_made;

Placement placed_on(const Charted& surface, const Drawing& drawing) {
  return *place(surface, &drawing, Settings(), Context());
}

// Two circles of 30 mm, 36 mm apart, meet at (18, +-24) from one of them.
TEST(Crossings, OfTwoCirclesAreWhereTheyMeet) {
  const Sample sheet = flat(300, 100);
  Drawing drawing;
  drawing.size_mm = {200, 200};
  drawing.elements = {ring("a", {7, 3}, 30), ring("b", {43, 3}, 30)};
  for (const PatternPlacement placement : {PatternPlacement::elements, PatternPlacement::chart}) {
    Settings settings;
    settings.pattern.placement = placement;
    const Charted surface(sheet);
    const auto found = crossings(drawing, *place(surface, &drawing, settings, Context()));
    ASSERT_EQ(found.size(), 2u);
    double low = 0, high = 0;
    for (const Crossing& c : found) {
      EXPECT_EQ(c.a, 0);
      EXPECT_EQ(c.b, 1);
      EXPECT_NEAR(c.rest.x(), 25, 0.02);
      EXPECT_NEAR(std::abs(c.rest.y() - 3), 24, 0.02);
      (c.rest.y() > 3 ? high : low) += 1;
      EXPECT_NEAR(c.place.x(), c.rest.x(), 1e-6);
      EXPECT_NEAR(c.sine, 2 * 0.6 * 0.8, 0.01);  // of the angle between their radii
      const LoopPath a(*drawing.elements[0].loop), b(*drawing.elements[1].loop);
      EXPECT_NEAR((a.at(c.along_a) - b.at(c.along_b)).norm(), 0, 0.02);
    }
    EXPECT_EQ(low, 1);
    EXPECT_EQ(high, 1);
  }
}

// Six around one, at 1.516 radii: each neighbour crosses twice.
TEST(Crossings, OfAnArrayAreTwoForEachPairOfNeighbours) {
  const Sample sheet = sphere(90, 400, 130);
  const Charted surface(sheet);
  const Drawing drawing = seven_rings(20, 1.516 * 20);
  EXPECT_EQ(crossings(drawing, placed_on(surface, drawing)).size(), 24u);  // 12 pairs
}

TEST(Crossings, OfAFigureOfEightIsOneOfItself) {
  const Sample sheet = flat(300, 100);
  const Charted surface(sheet);
  Drawing drawing;
  drawing.size_mm = {200, 200};
  Shape eight;
  Curve curve;
  curve.points = {{0, 0}, {40, 30}, {40, -30}, {0, 0}, {-40, 30}, {-40, -30}, {0, 0}};
  curve.closed = true;
  eight.curves = {curve};
  eight.stroke = Stroke{};
  eight.stroke->width_mm = 2;
  Shape turned = eight;  // so that it does not begin where it crosses itself
  turned.curves[0].points = {{30, 0},    {30, -15}, {12, -9}, {0, 0},   {-40, 30},
                             {-40, -30}, {0, 0},    {12, 9},  {30, 15}, {30, 0}};
  drawing.elements = {one_element("eight", {turned})};
  ASSERT_TRUE(drawing.elements[0].loop);
  const auto found = crossings(drawing, placed_on(surface, drawing));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].a, found[0].b);
  EXPECT_LT(found[0].rest.norm(), 0.1);
}

TEST(Crossings, OfLoopsApartAreNone) {
  const Sample sheet = flat(300, 100);
  const Charted surface(sheet);
  Drawing drawing;
  drawing.size_mm = {250, 250};
  drawing.elements = {ring("a", {0, 0}, 30), ring("inside", {2, 0}, 20), ring("far", {70, 0}, 30)};
  EXPECT_TRUE(crossings(drawing, placed_on(surface, drawing)).empty());
}

}  // namespace
}  // namespace vacuform
