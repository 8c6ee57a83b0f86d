#include "worker/conductors/tails.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/conductors/array_build.hpp"
#include "worker/conductors/cheapest_way.hpp"
#include "worker/pattern/drawn_loop.hpp"

namespace vacuform {
namespace {

using namespace hand_made;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double radius = 90;

// The sphere of hand_made::sphere() and back.
Vector3d on_sphere(const Vector2d& rest) {
  const double r = rest.norm(), a = r / radius;
  const Vector2d along = r > 0 ? Vector2d(rest / r) : Vector2d(1, 0);
  return {radius * std::sin(a) * along.x(), radius * std::sin(a) * along.y(), radius * std::cos(a)};
}
Vector2d on_sheet(const Vector3d& p) {
  const Vector2d flat = p.head<2>();
  const double r = radius * std::atan2(flat.norm(), p.z());
  return flat.norm() > 0 ? Vector2d(r * flat.normalized()) : Vector2d(0, 0);
}

// Loops on a sphere of 90 mm of which the part within `reach` mm of the pole is the head.
struct OnSphere {
  Sample sheet, below;
  Charted surface{sheet};
  Drawing drawing;
  Settings settings;

  explicit OnSphere(Drawing drawn, double reach = 105)
      : sheet(sphere(radius, 440, 140, reach)),
        below(sphere(radius - 0.8, 440, 140, reach)),
        drawing(std::move(drawn)) {
    for (std::size_t i = 0; i < sheet.sheet.formed.size(); ++i)
      below.sheet.formed[i] = sheet.sheet.formed[i] * (1 - 0.8 / radius);
    settings.coils.gaps = 2;
    settings.coils.tails = TailExit::nearest;
  }
  ArrayBuild build() {
    const Charted other(below.sheet, below.flattening);
    const auto placement = place(surface, &drawing, settings, Context());
    return *build_array(drawing, *placement, {surface, other}, std::nullopt, settings, Context());
  }
};

Drawing one_ring(const Vector2d& centre, double ring_radius) {
  Drawing out;
  out.size_mm = Vector2d::Constant(200);
  out.elements.push_back(ring("coil-0", centre, ring_radius));
  return out;
}

std::vector<Area> ink_of_step(const ArrayBuild& build, int element, PrintStep step) {
  std::vector<Area> out;
  for (const BuiltLayer& layer : build.layers)
    for (const LaidInkArea& ink : layer.laid)
      if (ink.element == element && layer.step == step) out.push_back(ink.area);
  return out;
}

bool covers(const std::vector<Area>& areas, const Vector2d& p) {
  return std::any_of(areas.begin(), areas.end(), [&](const Area& area) {
    bool inside = false;
    for (const Ring& ring : area) inside ^= is_inside(p, ring);
    return inside;
  });
}

// Straight across a tail on the sphere: where its ink begins and ends.
std::vector<double> edges_across(const std::vector<Area>& ink, const Vector2d& before, const Vector2d& at,
                                 const Vector2d& after) {
  const Vector3d p = on_sphere(at), up = p.normalized();
  const Vector3d ahead = on_sphere(after) - on_sphere(before), left = up.cross(ahead).normalized();
  std::vector<double> out;
  bool in = false;
  for (double mm = -4; mm < 4; mm += 0.005) {
    const double a = mm / radius;
    const bool inked = covers(ink, on_sheet(radius * (std::cos(a) * up + std::sin(a) * left)));
    if (inked != in) out.push_back(mm);
    in = inked;
  }
  return out;
}

TEST(Tails, LeadsAreAsWideAndAsFarApartOnTheSphereAsAsked) {
  OnSphere array(one_ring({25, 10}, 35));
  const ArrayBuild build = array.build();
  ASSERT_EQ(build.tails.size(), 1u);
  const Tail& tail = build.tails.front();
  EXPECT_TRUE(build.warnings.empty() && tail.crossings.empty());
  EXPECT_EQ(build.layers.size(), 1u);
  const std::vector<Area> ink = ink_of_step(build, 0, PrintStep::conductor);
  int measured = 0;
  for (std::size_t i = 40; i + 60 < tail.line.size(); i += 5) {
    const auto edges = edges_across(ink, tail.line[i - 8], tail.line[i], tail.line[i + 8]);
    ASSERT_EQ(edges.size(), 4u) << i;
    EXPECT_NEAR(edges[1] - edges[0], 1.5, 0.03);
    EXPECT_NEAR(edges[3] - edges[2], 1.5, 0.03);
    EXPECT_NEAR(edges[2] - edges[1], 0.9, 0.03);
    ++measured;
  }
  EXPECT_GT(measured, 5);
}

TEST(Tails, EndInTwoPadsBesideTheHead) {
  OnSphere array(one_ring({25, 10}, 35));
  const ArrayBuild build = array.build();
  const Tail& tail = build.tails.front();
  const std::vector<Area> ink = ink_of_step(build, 0, PrintStep::conductor);
  for (const Vector2d& pad : tail.pads) {
    EXPECT_TRUE(covers(ink, pad));
    EXPECT_GT(pad.norm(), 105 + 2);
    EXPECT_LT(pad.norm(), 105 + 16);
  }
  EXPECT_NEAR((on_sphere(tail.pads[0]) - on_sphere(tail.pads[1])).norm(), 2.54, 0.03);
  // From the middle of the trace to the ends of the pads, by chords of the sphere.
  double length = 0;
  for (std::size_t i = 1; i < tail.line.size(); ++i)
    length += (on_sphere(tail.line[i]) - on_sphere(tail.line[i - 1])).norm();
  EXPECT_NEAR(tail.length_mm, length - 0.35 * 3, 0.1);
  EXPECT_GT(tail.most_stretch, 0.9);
  EXPECT_NEAR(tail.squares, 2 * tail.length_mm / 1.5, 0.3 * tail.squares);
}

TEST(Tails, OfALoopInALoopGoesOverItOnBridges) {
  Drawing drawn = one_ring({0, 0}, 60);
  drawn.elements.push_back(ring("coil-1", {5, 0}, 25));
  OnSphere array(drawn);
  array.settings.coils.keep = CoilKeep::diameter;
  const ArrayBuild build = array.build();
  ASSERT_EQ(build.tails.size(), 2u);
  EXPECT_TRUE(build.tails[0].crossings.empty());
  ASSERT_EQ(build.tails[1].crossings.size(), 1u);
  EXPECT_EQ(build.tails[1].crossings[0].under, 0);
  ASSERT_EQ(build.tails[1].bridges.size(), 1u);
  const TailBridge& bridge = build.tails[1].bridges[0];
  // 3 mm of trace with .5 mm of clearance and .4 mm for the steps of the search on each side, a little more as the two leads do
  // not cross it at quite a right angle; and 1.5 mm of overlap.
  EXPECT_GT(bridge.cut.length(), 3 + 2 * 0.5);
  EXPECT_LT(bridge.cut.length(), 3 + 2 * (0.5 + 0.4) + 1);
  EXPECT_GE(bridge.cut.from - bridge.reach.from, 1.5);
  EXPECT_GE(bridge.reach.to - bridge.cut.to, 1.5);
  EXPECT_EQ(ink_of_step(build, 1, PrintStep::bridges).size(), 2u);
  ASSERT_EQ(build.layers.size(), 3u);
  EXPECT_EQ(build.layers[1].step, PrintStep::dielectric);
  EXPECT_EQ(build.layers[1].drawing.elements[0].shapes.size(), 1u);
  // Without a bridge, no lead comes near the trace of the other loop: a circle about the pole.
  for (const Area& area : ink_of_step(build, 1, PrintStep::conductor))
    for (const Ring& each : area)
      for (const Vector2d& p : each) EXPECT_GT(std::abs(p.norm() - 60), 1.5 + 0.5 - 0.05) << p.transpose();
}

TEST(Tails, OfSevenLoopsDoNotComeNearEachOther) {
  OnSphere array(seven_rings(30, 1.516 * 30));
  array.settings.coils.build = CoilBuild::bridges;
  const ArrayBuild build = array.build();
  EXPECT_EQ(build.tails.size(), 7u);
  EXPECT_TRUE(build.warnings.empty()) << build.warnings.front().text;
  EXPECT_FALSE(build.tails[0].crossings.empty()) << "the one in the middle is enclosed";
  for (const Tail& a : build.tails)
    for (const Tail& b : build.tails) {
      if (a.coil >= b.coil) continue;
      double least = 1e9;
      for (const Vector2d& p : a.line)
        for (const Vector2d& q : b.line) least = std::min(least, (on_sphere(p) - on_sphere(q)).norm());
      EXPECT_GT(least, 2 * 1.95 + 0.5) << a.coil << " " << b.coil;
    }
}

TEST(Tails, KeepToTheBackOfTheHead) {
  OnSphere array(one_ring({0, 40}, 30));
  array.settings.coils.tails = TailExit::back;
  const ArrayBuild build = array.build();
  ASSERT_EQ(build.tails.size(), 1u);
  EXPECT_LT(build.tails[0].rest.y(), -60);
  EXPECT_TRUE(build.tails[0].crossings.empty());
}

TEST(Tails, ThatFindNoWayAreSaid) {
  OnSphere array(one_ring({25, 10}, 35));
  array.settings.machine.window = WindowShape::circle;
  array.settings.machine.window_width_mm = 210;
  const ArrayBuild build = array.build();
  EXPECT_TRUE(build.tails.empty());
  ASSERT_EQ(build.warnings.size(), 1u);
  EXPECT_EQ(build.warnings[0].code, "tails-left-out");
  EXPECT_EQ(build.warnings[0].place, "coil-0");
  EXPECT_EQ(build.layers.size(), 1u);
}

TEST(Tails, AreTheSameTwice) {
  OnSphere array(seven_rings(30, 1.516 * 30));
  array.settings.coils.build = CoilBuild::two_faces;
  const ArrayBuild a = array.build(), b = array.build();
  ASSERT_EQ(a.tails.size(), b.tails.size());
  for (std::size_t i = 0; i < a.tails.size(); ++i) EXPECT_EQ(a.tails[i].line, b.tails[i].line);
}

TEST(CheapestWay, GoesStraightAroundTheEndOfAWall) {
  const Sample sheet = flat(100, 50);
  const Charted surface(sheet);
  const SheetCells cells(surface.surface, {Vector2d(-50, -50), Vector2d(50, 50)});
  WayCosts costs(static_cast<std::size_t>(cells.count()), 1);
  for (int c = 0; c < cells.count(); ++c)
    if (const Vector2d p = cells.middle(c); std::abs(p.x()) < 1 && p.y() < 20)
      costs[static_cast<std::size_t>(c)] = 0;
  const Vector2d from(-30, 0), to(30, 0);
  const auto way =
      cheapest_way(cells, costs, from, [&](int c) { return (cells.middle(c) - to).norm() < 0.5; });
  ASSERT_TRUE(way);
  EXPECT_LE(way->size(), 5u);
  double length = 0;
  for (std::size_t i = 1; i < way->size(); ++i) length += ((*way)[i] - (*way)[i - 1]).norm();
  EXPECT_NEAR(length, 2 * std::hypot(29, 20) + 2, 1);
  std::fill(costs.begin(), costs.end(), 0.0F);
  EXPECT_FALSE(cheapest_way(cells, costs, from, [&](int c) { return (cells.middle(c) - to).norm() < 0.5; }));
}

TEST(CheapestWay, RoundsCornersWhereThereIsRoom) {
  const std::vector<Vector2d> corner{{0, 0}, {20, 0}, {20, 20}};
  const auto turn = [](const std::vector<Vector2d>& line) {
    double most = 0;
    for (std::size_t i = 2; i < line.size(); ++i) {
      const Vector2d a = line[i - 1] - line[i - 2], b = line[i] - line[i - 1];
      most = std::max(most, std::acos(std::clamp(a.dot(b) / a.norm() / b.norm(), -1.0, 1.0)));
    }
    return most;
  };
  EXPECT_LT(turn(with_round_corners(corner, 5, [](std::size_t, const Vector2d&) { return true; })), 0.2);
  const auto tight = with_round_corners(
      corner, 5, [](std::size_t, const Vector2d& p) { return (p - Vector2d(17, 3)).norm() > 3.6; });
  for (const Vector2d& p : tight) EXPECT_GT((p - Vector2d(17, 3)).norm(), 2.9);
}

}  // namespace
}  // namespace vacuform
