#include "worker/placement/placement.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/placement/alignment.hpp"

namespace vacuform {
namespace {

TEST(Placement, TurnsMovesAndScalesOnTheChart) {
  FormedSheet sheet;
  sheet.triangles = {{0, 1, 2}, {1, 3, 2}};
  sheet.rest = {{0, 0}, {10, 0}, {0, 10}, {10, 10}};
  Flattening flattening;
  flattening.triangles = {1};
  flattening.chart = {{NAN, NAN}, {12, 0}, {0, 12}, {12, 12}};
  sheet.formed = {{0, 0, 5}, {10, 0, 5}, {0, 10, 5}, {10, 10, 5}};
  Settings settings;
  settings.pattern.offset_mm = {2, 0};
  settings.pattern.rotate_deg = 90;
  settings.pattern.scale = 2;
  const auto placed = place(hand_made::Charted(sheet, flattening), nullptr, settings, Context());
  ASSERT_TRUE(placed);
  ASSERT_EQ(placed->charts.size(), 1u);
  const Patch& chart = placed->charts[0].patch;
  ASSERT_EQ(chart.triangles.size(), 1u);
  ASSERT_EQ(chart.uv.size(), 3u);
  EXPECT_TRUE(chart.rest[0].isApprox(Eigen::Vector2d(10, 0)));
  // The chart's (12, 0) is 10 mm to the right of the drawing's centre; the drawing was turned left and doubled.
  EXPECT_LT((chart.uv[0] - Eigen::Vector2d(0, -5)).norm(), 1e-12);
  EXPECT_TRUE(placed->elements.empty());
}

using Eigen::Vector2d;
using Eigen::Vector3d;
using hand_made::Sample;

Result<Placement> placed(const Sample& x, const Drawing& drawing, const Settings& settings = {}) {
  return place(hand_made::Charted(x), &drawing, settings, Context());
}

TEST(Placement, NeighboursOnASphereHaveTheDrawnDistancesAsNearlyAsItLets) {
  const Sample x = hand_made::sphere(85, 240, 120);
  Drawing drawing = hand_made::seven_rings(20, 30.32);
  const auto p = placed(x, drawing);
  ASSERT_TRUE(p);
  ASSERT_EQ(p->elements.size(), 7u);
  EXPECT_EQ(p->pairs.size(), 12u);  // six spokes, six sides
  // On the sphere six sides of 60 degrees do not close: spokes come out longer than sides.
  EXPECT_GT(p->spacing_rms_mm, 0.05);
  EXPECT_LT(p->spacing_rms_mm, 0.4);
  for (const PlacedElement& e : p->elements) {
    EXPECT_TRUE(e.on_head);
    EXPECT_EQ(e.size, 1);
    EXPECT_LT(e.moved_mm, 1);
    EXPECT_LT(std::abs(e.turned_deg), 1);
  }
  EXPECT_LT((p->elements[0].centre - Vector3d(0, 0, 85)).norm(), 0.1);  // no drift
  EXPECT_TRUE(p->warnings.empty());
  for (const PlacedPair& pair : p->pairs) {
    EXPECT_NEAR(pair.drawn_mm, 30.32, 1e-9);
  }
}

TEST(Placement, MeetsTheDrawnDistancesOnlyAsNearlyAsTheSurfaceLets) {
  const Sample x = hand_made::sphere(45, 180, 90);
  const auto p = placed(x, hand_made::seven_rings(30, 45));
  ASSERT_TRUE(p);
  EXPECT_GT(p->spacing_rms_mm, 2);
}

TEST(Placement, TellsWhatLiesOffTheHeadAndLeavesOutWhatLiesBeyondIt) {
  const Sample x = hand_made::sphere(85, 240, 120, 60);
  Drawing drawing;
  drawing.elements = {hand_made::ring("in", {0, 0}, 20), hand_made::ring("half", {55, 0}, 15),
                      hand_made::ring("beyond", {0, 62}, 10), hand_made::ring("gone", {-90, 0}, 20)};
  const auto p = placed(x, drawing);
  ASSERT_TRUE(p);
  ASSERT_EQ(p->elements.size(), 3u);
  EXPECT_TRUE(p->elements[0].on_head);
  EXPECT_FALSE(p->elements[1].on_head);
  EXPECT_FALSE(p->elements[2].on_head);
  EXPECT_NEAR(p->elements[2].centre_rest.y(), 62, 0.5);  // straight on from the chart's edge
  ASSERT_EQ(p->warnings.size(), 2u);
  EXPECT_EQ(p->warnings[0].code, "coil-left-out");
  EXPECT_NE(p->warnings[0].text.find("gone"), std::string::npos);
  EXPECT_EQ(p->warnings[1].code, "coil-off-head");
  EXPECT_NE(p->warnings[1].text.find("half and beyond"), std::string::npos);
}

TEST(Placement, UsesOneChartOnRequestOrWithoutIds) {
  const Sample x = hand_made::flat(100, 20);
  Drawing drawing;
  drawing.elements = {hand_made::ring("", {0, 0}, 20)};
  EXPECT_TRUE(placed(x, drawing)->elements.empty());
  Settings settings;
  settings.pattern.placement = PatternPlacement::elements;
  const auto refused = placed(x, drawing, settings);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::unusable_pattern);
  drawing.elements[0].id = "a";
  EXPECT_EQ(placed(x, drawing, settings)->elements.size(), 1u);
  settings.pattern.placement = PatternPlacement::chart;
  EXPECT_TRUE(placed(x, drawing, settings)->elements.empty());
}

Result<Alignment> aligned(const Sample& x, const PatternSettings& settings) {
  return align(hand_made::Charted(x), settings);
}

TEST(Alignment, ShiftsByOnePointAndTurnsByTwo) {
  const Sample x = hand_made::flat(100, 20);
  PatternSettings s;
  s.points = {{10, 0, 5, 7, 2}};
  auto a = aligned(x, s);
  ASSERT_TRUE(a);
  EXPECT_LT((a->chart({10, 0}) - Vector2d(5, 7)).norm(), 1e-9);
  EXPECT_EQ(a->turn_deg, 0);
  // The offset shifts the meeting point, the turn leaves it.
  s.offset_mm = {1, 2};
  s.rotate_deg = 30;
  a = aligned(x, s);
  EXPECT_LT((a->chart({10, 0}) - Vector2d(6, 9)).norm(), 1e-9);
  EXPECT_NEAR(a->turn_deg, 30, 1e-9);

  s = {};
  s.scale = 2;
  s.points = {{0, 0, 5, 5, 0}, {10, 0, 5, 20, 0}};
  a = aligned(x, s);
  EXPECT_LT((a->chart({0, 0}) - Vector2d(5, 5)).norm(), 1e-9);
  EXPECT_NEAR(a->turn_deg, 90, 1e-9);
  EXPECT_LT((a->chart({10, 0}) - Vector2d(5, 25)).norm(), 1e-9);  // its size is its own
  EXPECT_LT((a->pattern(a->chart({3, -4})) - Vector2d(3, -4)).norm(), 1e-9);
}

// The sphere with a chart that is too large and twisted more and more with the distance from the top, by `twist`
// radians at one radius.
Sample twisted_sphere(double radius, double twist, double reach = 1e9) {
  Sample x = hand_made::sphere(radius, 240, 120, 0);
  hand_made::lay_chart(x, reach, [&](const Vector2d& st) -> Vector2d {
    return 1.15 * (Eigen::Rotation2Dd(twist * st.squaredNorm() / (radius * radius)) * st);
  });
  return x;
}
// The point of the sphere that is reached from the top by `way`, and the u axis of the top carried there.
struct OnSphere {
  Vector3d place, u;
};
OnSphere on_sphere(double radius, const Vector2d& way) {
  const double a = way.norm() / radius, around = std::atan2(way.y(), way.x());
  const Vector3d out(std::cos(around), std::sin(around), 0), aside(-out.y(), out.x(), 0);
  return {
      radius * (std::sin(a) * out + std::cos(a) * Vector3d::UnitZ()),
      std::cos(around) * (std::cos(a) * out - std::sin(a) * Vector3d::UnitZ()) - std::sin(around) * aside};
}

TEST(Alignment, OffsetsAreAlongTheSurfaceWhateverTheChart) {
  constexpr double R = 85;
  const Sample x = twisted_sphere(R, 0.6);
  const hand_made::Charted charted(x);
  const ChartedSurface& surface = charted;
  Drawing drawing;
  drawing.elements = {hand_made::ring("coil", {0, 0}, 15)};
  for (const Vector2d& by :
       {Vector2d(20, 0), Vector2d(0, 30), Vector2d(-36, 48), Vector2d(-13, -57), Vector2d(3, 1)})
    for (const double turn_deg : {0.0, 40.0}) {
      PatternSettings s;
      s.offset_mm = {by.x(), by.y()};
      s.rotate_deg = turn_deg;
      const OnSphere meant = on_sphere(R, by);
      // One coil, with the direction of its u axis.
      Settings settings;
      settings.pattern = s;
      const auto p = placed(x, drawing, settings);
      ASSERT_TRUE(p) << p.error().text();
      const Centre& coil = p->layout.centres.at(0);
      EXPECT_LT((p->elements.at(0).centre - meant.place).norm(), 0.1) << by.transpose();
      const Vector3d u = turned(surface.surface(), coil.point.triangle, coil.axis, -turn_deg * M_PI / 180);
      EXPECT_LT((u - meant.u).norm(), 0.03) << by.transpose();
      // The drawing on the chart: its centre, and its u axis about that.
      const auto a = align(charted, s);
      ASSERT_TRUE(a);
      const auto at = [&](const Vector2d& uv) {
        return surface.surface().place(surface.at_chart(a->chart(uv)).point);
      };
      EXPECT_LT((at({0, 0}) - meant.place).norm(), 0.1) << by.transpose();
      const Vector2d drawn_u = Eigen::Rotation2Dd(-turn_deg * M_PI / 180) * Vector2d(2, 0);
      const double along = ((at(drawn_u) - at(-drawn_u)).normalized() - meant.u).norm();
      EXPECT_LT(along, 0.3) << by.transpose();  // the chart shears by its twist
    }
}

TEST(Alignment, OffsetsOfPointsBeginWhereThePointsPutTheDrawing) {
  constexpr double R = 85;
  const Sample x = twisted_sphere(R, 0);
  const hand_made::Charted charted(x);
  const Vector3d on = on_sphere(R, {25, 10}).place;
  PatternSettings s;
  s.points = {{4, -7, on.x(), on.y(), on.z()}};
  s.rotate_deg = 25;
  for (const double mm : {12.0, 45.0}) {
    s.offset_mm = {-0.6 * mm, 0.8 * mm};
    const auto a = align(charted, s);
    ASSERT_TRUE(a);
    const ChartedSurface& surface = charted;
    const Vector3d to = surface.surface().place(surface.at_chart(a->chart({4, -7})).point);
    EXPECT_NEAR(R * std::acos(to.dot(on) / (R * R)), mm, 0.1);
  }
}

TEST(Alignment, RefusesAnOffsetThatLeadsOffThePart) {
  const Sample x = twisted_sphere(85, 0.3, 60);
  PatternSettings s;
  s.offset_mm = {-64, 48};
  const auto a = aligned(x, s);
  ASSERT_FALSE(a);
  EXPECT_EQ(a.error().code, Code::bad_settings);
  EXPECT_EQ(a.error().where, "pattern.offset_mm");
  EXPECT_EQ(a.error().what.rfind("the offset leads off the formed part after 5", 0), 0u) << a.error().what;
  // Pins may put the origin of the chart where there is no surface: the offset then shifts the drawing in the chart.
  Sample pinned = hand_made::flat(40, 20);
  for (Vector2d& p : pinned.flattening.chart) p += Vector2d(100, 0);
  s.offset_mm = {90, 3};
  EXPECT_LT((aligned(pinned, s)->shift_mm - Vector2d(90, 3)).norm(), 1e-12);
}

TEST(Placement, AnArrayKeepsItsCentreOnTheOffset) {
  constexpr double R = 85;
  // A chart whose scale changes from left to right, so that it puts the coils on one side too far out.
  Sample x = hand_made::sphere(R, 240, 120, 0);
  hand_made::lay_chart(x, 1e9, [](const Vector2d& st) -> Vector2d { return (1 + 0.002 * st.x()) * st; });
  const Drawing drawing = hand_made::seven_rings(20, 30.32);
  const auto still = placed(x, drawing);
  ASSERT_TRUE(still);
  for (const Vector2d& by : {Vector2d(20, 0), Vector2d(-24, 32)}) {
    Settings settings;
    settings.pattern.offset_mm = {by.x(), by.y()};
    const auto p = placed(x, drawing, settings);
    ASSERT_TRUE(p) << p.error().text();
    const Vector3d &from = still->elements[0].centre, &to = p->elements[0].centre;
    EXPECT_NEAR(R * std::acos(from.normalized().dot(to.normalized())), by.norm(), 0.05) << by.transpose();
    EXPECT_NEAR(p->spacing_rms_mm, still->spacing_rms_mm, 0.02);
  }
}

TEST(Alignment, FitsThreePointsByRigidLeastSquares) {
  const Sample x = hand_made::flat(100, 20);
  PatternSettings s;
  const Alignment exact{25, 1, {4, -6}};
  for (const Vector2d& p : {Vector2d(10, 0), Vector2d(-12, 8), Vector2d(3, -15)}) {
    const Vector2d q = exact.chart(p);
    s.points.push_back({p.x(), p.y(), q.x(), q.y(), 0});
  }
  const auto a = aligned(x, s);
  ASSERT_TRUE(a);
  EXPECT_NEAR(a->turn_deg, 25, 1e-9);
  EXPECT_LT((a->shift_mm - exact.shift_mm).norm(), 1e-9);
}

TEST(Alignment, RefusesPointsOffThePartAndPointsWithoutDirection) {
  const Sample x = hand_made::flat(100, 20);
  PatternSettings s;
  s.points = {{0, 0, 0, 0, 0}, {10, 0, 80, 0, 0}};
  auto a = aligned(x, s);
  ASSERT_FALSE(a);
  EXPECT_EQ(a.error().code, Code::bad_settings);
  EXPECT_EQ(a.error().where, "pattern.points[1]");
  s.points = {{0, 0, 0, 0, 0}, {0, 0, 10, 0, 0}};
  EXPECT_EQ(aligned(x, s).error().where, "pattern.points");
}

}  // namespace
}  // namespace vacuform
