#include "worker/placement/length_errors.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/surface/geodesic.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using hand_made::Sample;

constexpr double radius = 85;

struct Laid {
  Placement placement;
  LengthErrors errors;
};
Laid laid(const Sample& x, const Drawing& drawing, const Settings& settings = {}) {
  auto placed = place(hand_made::Charted(x), &drawing, settings, Context());
  if (!placed) throw std::runtime_error(placed.error().text());
  const Pattern none = Pattern::of_picture({1, 1}, {0, 0, 0, 0}, {1, 1}, "none");
  LengthErrors errors = length_errors(&drawing, none, *placed, {}, settings.pattern.scale);
  return {std::move(*placed), std::move(errors)};
}

Drawing of(std::vector<Element> elements) {
  Drawing out;
  out.size_mm = {300, 300};
  out.elements = std::move(elements);
  return out;
}

// In its own neighbourhood a circle keeps its area, and on the chart its radius; the sphere says how long it then is.
TEST(LengthErrors, AreThoseOfCirclesOnASphere) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  Settings on_chart;
  on_chart.pattern.placement = PatternPlacement::chart;
  for (const double r : {20.0, 35.0}) {
    const Drawing drawing = of({hand_made::ring("coil", {0, 0}, r)});
    const double by_area = radius * std::sqrt(1 - std::pow(1 - r * r / (2 * radius * radius), 2)) / r - 1;
    const double by_radius = radius * std::sin(r / radius) / r - 1;
    const auto own = laid(x, drawing).errors;
    EXPECT_NEAR(own.mean, -by_area, 0.001) << r;
    for (const auto& piece : own.pieces) EXPECT_NEAR(piece.error, by_area, 0.008) << r;
    const auto errors = laid(x, drawing, on_chart).errors;
    for (const auto& piece : errors.pieces) EXPECT_NEAR(piece.error, by_radius, 0.002) << r;
    EXPECT_NEAR(errors.mean, -by_radius, 0.002);
    double drawn = 0;
    for (const auto& piece : errors.pieces) drawn += piece.drawn_mm;
    EXPECT_NEAR(drawn, 2 * M_PI * r, 0.1);
  }
}

TEST(LengthErrors, AreWarnedOfByTheirSize) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  Settings on_chart;
  on_chart.pattern.placement = PatternPlacement::chart;
  const auto code_of = [&](double r) -> std::string {
    const Drawing drawing = of({hand_made::ring("inner", {0, 0}, 12), hand_made::ring("wide", {0, 0}, r)});
    const auto warning = length_warning(laid(x, drawing, on_chart).errors, &drawing, 0.02);
    if (!warning) return {};
    EXPECT_EQ(warning->place, "wide");
    EXPECT_FALSE(warning->marks.empty());
    return warning->code;
  };
  EXPECT_EQ(code_of(25), "");  // 1.4 %
  EXPECT_EQ(code_of(50), "length-off");
  EXPECT_EQ(code_of(78), "length-far-off");
}

TEST(LengthErrors, OfAPictureAreThoseOfItsInk) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  Settings on_chart;
  on_chart.pattern.placement = PatternPlacement::chart;
  const auto placed = place(hand_made::Charted(x), nullptr, on_chart, Context());
  ASSERT_TRUE(placed);
  // Black from 45 to 55 mm to the right of the middle: along v, where the chart is too wide, it shrinks.
  std::vector<std::uint8_t> pixels(4 * 160 * 160, 0);
  for (std::size_t j = 70; j < 90; ++j)
    for (std::size_t i = 125; i < 135; ++i) pixels[4 * (160 * j + i) + 3] = 255;
  const Pattern picture = Pattern::of_picture({160, 160}, std::move(pixels), {160, 160}, "made");
  const auto errors = length_errors(nullptr, picture, *placed, {}, 1);
  ASSERT_FALSE(errors.pieces.empty());
  EXPECT_NEAR(errors.worst, 1 - radius * std::sin(57.5 / radius) / 57.5, 0.01);
  EXPECT_EQ(length_warning(errors, nullptr, 0.02)->code, "length-off");
}

// A line that two coils pull to 22 mm: the print counts, not the chart.
TEST(LengthErrors, OfTiedLinesAreThoseOfThePrint) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  Settings on_chart;
  on_chart.pattern.placement = PatternPlacement::chart;
  Shape shape;
  shape.curves = {Curve{{{0, 0}, {6, 0}, {14, 0}, {20, 0}}, false}};
  shape.stroke = Stroke{};
  const Drawing drawing = of({{"", {0, 0}, {shape}, {}, {}}});
  const auto placed = place(hand_made::Charted(x), &drawing, on_chart, Context());
  ASSERT_TRUE(placed);
  TiedPoints tied{0, 0, 0, {}, {}};
  for (int i = 0; i <= 40; ++i) {
    tied.drawn.emplace_back(0.5 * i, 0);
    tied.rest.emplace_back(0.55 * i, 0);
  }
  const Pattern none = Pattern::of_picture({1, 1}, {0, 0, 0, 0}, {1, 1}, "none");
  const auto errors = length_errors(&drawing, none, *placed, {tied}, 1);
  ASSERT_EQ(errors.pieces.size(), 2u);
  for (const auto& piece : errors.pieces) EXPECT_NEAR(piece.error, 0.1, 0.002);
}

const ChartedSurface& surface_of(const ChartedSurface& charted) { return charted; }

// Three coils around one, 40, 40 and 50 mm apart; none is near another.
TEST(PlacementGraph, HoldsDistancesNearAndFar) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  const hand_made::Charted charted(x);
  Drawing drawing = of({hand_made::ring("a", {3, 4}, 15), hand_made::ring("b", {43, 4}, 15),
                        hand_made::ring("c", {-37, 4}, 15), hand_made::ring("d", {3, -46}, 15)});
  const auto p = place(charted, &drawing, {}, Context());
  ASSERT_TRUE(p);
  ASSERT_EQ(p->pairs.size(), 3u);
  for (const PlacedPair& pair : p->pairs) EXPECT_NEAR(pair.mm, pair.drawn_mm, 0.05);
}

TEST(PlacementGraph, ASingleCoilLiesAtItsDrawnDistanceFromTheTop) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  const hand_made::Charted charted(x);
  const Drawing drawing = of({hand_made::ring("coil", {33, -41}, 15)});
  const auto p = place(charted, &drawing, {}, Context());
  ASSERT_TRUE(p);
  const auto top = surface_of(charted).at_chart({0, 0});
  const auto there = surface_of(charted).at_chart(p->elements[0].centre_rest);  // the chart is the sheet
  EXPECT_NEAR(connect(surface_of(charted).surface(), top.point, there.point).mm, std::hypot(33, 41), 0.05);
}

// A loop about the same centre and a word follow the coil, wherever its neighbours move it.
TEST(PlacementGraph, NestedLoopsAndFiguresFollowTheirCoil) {
  const Sample x = hand_made::sphere(radius, 240, 120);
  const hand_made::Charted charted(x);
  Shape word;
  word.curves = {circle({62, 30}, 3)};
  word.fill = Colour{};
  Drawing drawing = of({hand_made::ring("a", {-30, 2}, 18), hand_made::ring("b", {40, 5}, 18),
                        hand_made::ring("in-b", {40, 5}, 9), one_element("word", {word})});
  const auto p = place(charted, &drawing, {}, Context());
  ASSERT_TRUE(p);
  ASSERT_EQ(p->pairs.size(), 1u);
  EXPECT_LT((p->elements[1].centre - p->elements[2].centre).norm(), 1e-9);
  const auto b = surface_of(charted).at_chart(p->elements[1].centre_rest),
             at = surface_of(charted).at_chart(p->elements[3].centre_rest);
  EXPECT_NEAR(connect(surface_of(charted).surface(), b.point, at.point).mm, std::hypot(22, 25), 0.05);
}

}  // namespace
}  // namespace vacuform
