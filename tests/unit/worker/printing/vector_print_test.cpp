#include "worker/printing/vector_print.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "worker/pattern/area.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/sorting.hpp"
#include "worker/printing/curve_fit.hpp"
#include "worker/printing/seam_gap.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A sphere of 60 mm: its pole is in the sheet's middle, and the sheet was stretched evenly along each meridian.
constexpr double R = 60, shrink = 0.8;

Vector2d rest_of(const Vector3d& p) {
  const double angle = std::acos(std::clamp(p.z() / R, -1.0, 1.0));
  const Vector2d along(p.x(), p.y());
  return along.norm() > 0 ? Vector2d(shrink * R * angle * along.normalized()) : Vector2d(0, 0);
}
// The exponential map about the point `polar` radians off the pole, towards +x.
Vector3d exponential(double polar, const Vector2d& uv) {
  const double r = uv.norm() / R;
  const Vector3d centre(std::sin(polar), 0, std::cos(polar)), east(std::cos(polar), 0, -std::sin(polar)),
      north(0, 1, 0);
  const Vector3d away = uv.norm() > 0 ? Vector3d((uv.x() * east + uv.y() * north) / uv.norm()) : east;
  return R * (std::cos(r) * centre + std::sin(r) * away);
}
// Triangles of `step` mm over the square of `half` mm around `centre` in the pattern.
template <class Surface>
Patch patch_of(const Vector2d& centre, double half, double step, Surface&& surface) {
  Patch patch;
  const int n = static_cast<int>(std::lround(2 * half / step));
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const Vector2d uv = centre + Vector2d(i * step - half, j * step - half);
      patch.uv.push_back(uv);
      patch.inked.push_back(surface(uv));
      patch.rest.push_back(rest_of(patch.inked.back()));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      patch.triangles.push_back({a, b, d});
      patch.triangles.push_back({a, d, c});
    }
  return patch;
}
Segment whole(Patch patch) {
  Segment out{std::move(patch), {}, 1};
  out.triangles.resize(out.patch.triangles.size());
  std::iota(out.triangles.begin(), out.triangles.end(), 0);
  return out;
}
Patch identity(double half, double step) {
  Patch patch = patch_of({0, 0}, half, step, [](const Vector2d& uv) { return Vector3d(uv.x(), uv.y(), 0); });
  patch.rest = patch.uv;
  return patch;
}

Curve circle(const Vector2d& centre, double r) {
  const double k = 4.0 / 3 * (std::sqrt(2.0) - 1);
  Curve out{.points = {centre + Vector2d(r, 0)}, .closed = true};
  for (int i = 0; i < 4; ++i) {
    const Eigen::Rotation2Dd turn(M_PI / 2 * i);
    for (const Vector2d& p : {Vector2d(1, k), Vector2d(k, 1), Vector2d(0, 1)})
      out.points.push_back(centre + r * (turn * p));
  }
  out.points.back() = out.points.front();
  return out;
}
Curve line(const std::vector<Vector2d>& through, bool closed = false) {
  Curve out{.points = {through.front()}, .closed = closed};
  for (std::size_t i = 1; i < through.size() + (closed ? 1 : 0); ++i) {
    const Vector2d a = through[i - 1], b = through[i % through.size()];
    for (const Vector2d& p : {Vector2d(a + (b - a) / 3), Vector2d(b - (b - a) / 3), b})
      out.points.push_back(p);
  }
  return out;
}
Shape stroked(const Curve& curve, double width) {
  Shape out;
  out.curves = {curve};
  out.stroke = Stroke{};
  out.stroke->width_mm = width;
  return out;
}
Shape filled(const Curve& curve) {
  Shape out;
  out.curves = {curve};
  out.fill = Colour{};
  return out;
}
Drawing drawing_of(std::vector<Element> elements, double side = 120) {
  return {.size_mm = {side, side}, .elements = std::move(elements)};
}
VectorPrint pull(const Drawing& drawing, const Placement& placement, const Settings& settings = {}) {
  auto out = pull_back(drawing, placement, settings, Context());
  if (!out) throw std::runtime_error(out.error().text());
  return std::move(*out);
}

std::vector<Vector2d> points_of(const Curve& curve) {
  std::vector<Vector2d> out;
  for (const CurvePoint& p : flatten(curve, {.tolerance_mm = 1e-4, .turn = 0.05, .longest_mm = 0.05}))
    out.push_back(p.at);
  return out;
}
double distance_to(const std::vector<Vector2d>& polyline, const Vector2d& p) {
  double least = 1e9;
  for (std::size_t i = 1; i < polyline.size(); ++i) {
    const Vector2d a = polyline[i - 1], d = polyline[i] - a;
    const double f = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
    least = std::min(least, (a + f * d - p).norm());
  }
  return least;
}
double farthest(const std::vector<Vector2d>& from, const std::vector<Vector2d>& to) {
  double most = 0;
  for (const Vector2d& p : from) most = std::max(most, distance_to(to, p));
  return most;
}
double hausdorff(const Curve& curve, const std::vector<Vector2d>& exact) {
  const auto points = points_of(curve);
  return std::max(farthest(points, exact), farthest(exact, points));
}
std::vector<Vector2d> exact_circle(double polar, double r) {
  std::vector<Vector2d> out;
  for (int i = 0; i <= 3000; ++i) {
    const double a = 2 * M_PI * i / 3000;
    out.push_back(rest_of(exponential(polar, r * Vector2d(std::cos(a), std::sin(a)))));
  }
  return out;
}
double total(const PrintedElement& element) {
  double sum = 0;
  for (const PaintedArea& a : element.areas) sum += square_mm(fill_area(a.outlines, a.even_odd, 1e-3));
  return sum;
}

TEST(VectorPrint, ACoilThroughAnExactExponentialMap) {
  Placement placement;
  placement.charts = {whole(identity(60, 5))};
  PlacedElement placed;
  placed.patch = patch_of({0, 0}, 27, 1.5, [](const Vector2d& uv) { return exponential(0.7, uv); });
  placement.elements.push_back(placed);
  const VectorPrint print = pull(
      drawing_of({{.id = "coil", .centre = {0, 0}, .shapes = {stroked(circle({0, 0}, 20), 3)}}}), placement);
  ASSERT_EQ(print.elements.size(), 1u);
  ASSERT_EQ(print.elements[0].areas.size(), 1u);
  const auto& outlines = print.elements[0].areas[0].outlines;
  ASSERT_EQ(outlines.size(), 2u);
  const double outer = std::min(hausdorff(outlines[0], exact_circle(0.7, 21.5)),
                                hausdorff(outlines[1], exact_circle(0.7, 21.5)));
  const double inner = std::min(hausdorff(outlines[0], exact_circle(0.7, 18.5)),
                                hausdorff(outlines[1], exact_circle(0.7, 18.5)));
  ASSERT_EQ(print.elements[0].centrelines.size(), 1u);
  const Centreline& middle = print.elements[0].centrelines[0];
  const double centre = hausdorff(middle.curve, exact_circle(0.7, 20));
  EXPECT_LT(outer, 0.02);
  EXPECT_LT(inner, 0.02);
  EXPECT_LT(centre, 0.02);
  EXPECT_TRUE(middle.curve.closed);
  EXPECT_EQ(middle.width_mm, 3);
  EXPECT_LE(outlines[0].points.size(), 3 * 24 + 1u);
  EXPECT_NEAR(print.painted_mm2, M_PI * (21.5 * 21.5 - 18.5 * 18.5), 0.1);
  EXPECT_EQ(print.lost_mm2, 0);
}

TEST(VectorPrint, AFilledRingHasTheMiddleOfItsEdgesAsItsCentreLine) {
  Placement placement;
  placement.charts = {whole(identity(60, 5))};
  PlacedElement placed;
  placed.patch = patch_of({0, 0}, 27, 1.5, [](const Vector2d& uv) { return exponential(0.7, uv); });
  placement.elements.push_back(placed);
  Shape ring = filled(circle({0, 0}, 21.5));
  ring.curves.push_back(circle({0, 0}, 18.5));
  ring.even_odd = true;
  const auto printed = [&](const std::string& id) {
    return pull(drawing_of({one_element(id, {ring})}), placement).elements[0];
  };
  const PrintedElement coil = printed("coil");
  EXPECT_EQ(coil.areas.size(), 1u);
  ASSERT_EQ(coil.centrelines.size(), 1u);
  EXPECT_TRUE(coil.centrelines[0].curve.closed);
  EXPECT_LT(hausdorff(coil.centrelines[0].curve, exact_circle(0.7, 20)), 0.02);
  EXPECT_LE(coil.centrelines[0].curve.points.size(), 3 * 32 + 1u);
  EXPECT_NEAR(coil.centrelines[0].width_mm, 3, 0.002);
  EXPECT_TRUE(printed("").centrelines.empty());
}

TEST(VectorPrint, TheIdentityGivesTheDrawingBack) {
  Placement placement;
  placement.charts = {whole(identity(60, 3))};
  Shape star = filled(line({{0, 16}, {9.4, -13}, {-15.2, 5}, {15.2, 5}, {-9.4, -13}}, true));
  star.even_odd = true;
  Shape zigzag = stroked(line({{-40, 30}, {-30, 45}, {-20, 30}, {5, 40}}), 4);
  const VectorPrint print =
      pull(drawing_of({{.id = "dot", .centre = {0, 0}, .shapes = {filled(circle({-20, -25}, 10))}},
                       {.id = "star", .centre = {0, 0}, .shapes = {star}},
                       {.id = "line", .centre = {0, 0}, .shapes = {zigzag}}}),
           placement);
  const Curve& dot = print.elements[0].areas[0].outlines[0];
  EXPECT_LT(hausdorff(dot, points_of(circle({-20, -25}, 10))), 0.012);
  EXPECT_NEAR(total(print.elements[1]), square_mm(fill_area(star.curves, true, 1e-3)), 0.01);
  // Corners stay corners, and straight sides have one segment each.
  EXPECT_EQ(print.elements[2].areas[0].outlines[0].points.size(), 3 * 8 + 1u);
  EXPECT_LT(hausdorff(print.elements[2].centrelines[0].curve, points_of(zigzag.curves[0])), 1e-5);
  EXPECT_EQ(print.elements[2].centrelines[0].curve.points.size(), 3 * 3 + 1u);
}

TEST(VectorPrint, AFormedLineHasItsDrawnWidth) {
  // Measured on the sphere: the width of the ring, between the pulled-back outlines after the exact map.
  Placement placement;
  PlacedElement placed;
  placed.patch = patch_of({0, 0}, 40, 1.5, [](const Vector2d& uv) { return exponential(0.9, uv); });
  placement.charts = {whole(placed.patch)};
  placement.elements.push_back(placed);
  Settings settings;
  for (const double size : {1.0, 1.04}) {
    // A coil that was resized: its patch moves it outwards, its line keeps its width.
    placement.elements[0].size = size;
    for (Vector2d& uv : placement.elements[0].patch.uv) uv /= size;
    const VectorPrint print =
        pull(drawing_of({{.id = "coil", .centre = {0, 0}, .shapes = {stroked(circle({0, 0}, 20), 3)}}}),
             placement, settings);
    std::vector<double> radii[2];
    const auto& outlines = print.elements[0].areas[0].outlines;
    ASSERT_EQ(outlines.size(), 2u);
    const Vector3d centre = exponential(0.9, {0, 0});
    for (int k = 0; k < 2; ++k)
      for (const Vector2d& st : points_of(outlines[static_cast<std::size_t>(k)])) {
        const double angle = st.norm() / (shrink * R);
        const Vector3d p(R * std::sin(angle) * st.x() / st.norm(), R * std::sin(angle) * st.y() / st.norm(),
                         R * std::cos(angle));
        radii[k].push_back(R * std::acos(std::clamp(p.dot(centre) / (R * R), -1.0, 1.0)));
      }
    if (radii[0].front() > radii[1].front()) std::swap(radii[0], radii[1]);
    const auto [low0, high0] = std::minmax_element(radii[0].begin(), radii[0].end());
    const auto [low1, high1] = std::minmax_element(radii[1].begin(), radii[1].end());
    EXPECT_NEAR(*high1 - *low0, 3, 0.03);
    EXPECT_NEAR(*low1 - *high0, 3, 0.03);
    EXPECT_NEAR((*high1 + *low0) / 2, 20 * size, 0.02);
  }
}

TEST(VectorPrint, CutsLinesAtTheBorderOfThePatch) {
  Placement placement;
  placement.charts = {whole(identity(30, 3))};
  const VectorPrint print =
      pull(drawing_of({{.id = "bar", .centre = {0, 0}, .shapes = {stroked(line({{-50, 3}, {20, 3}}), 2)}},
                       {.id = "ring", .centre = {0, 0}, .shapes = {stroked(circle({30, -10}, 8), 1)}},
                       {.id = "off", .centre = {0, 0}, .shapes = {filled(circle({45, 45}, 3))}}}),
           placement);
  EXPECT_NEAR(total(print.elements[0]), 100, 0.01);
  const auto& centre = print.elements[0].centrelines[0].curve.points;
  EXPECT_LT((centre.front() - Vector2d(-30, 3)).norm(), 2e-3);
  EXPECT_LT((centre.back() - Vector2d(20, 3)).norm(), 1e-6);
  EXPECT_NEAR(total(print.elements[1]), M_PI * 8, 0.05);
  ASSERT_EQ(print.elements[1].centrelines.size(), 1u);  // one arc, through the start point of the circle
  EXPECT_FALSE(print.elements[1].centrelines[0].curve.closed);
  EXPECT_TRUE(print.elements[2].areas.empty());
  EXPECT_NEAR(print.lost_mm2, 40 + M_PI * 8 + M_PI * 9, 0.1);
  EXPECT_NEAR(print.painted_mm2, 140 + M_PI * 16 + M_PI * 9, 0.1);
}

TEST(VectorPrint, ThePageCutsToo) {
  Placement placement;
  placement.charts = {whole(identity(60, 5))};
  const VectorPrint print = pull(
      drawing_of({{.id = "bar", .centre = {0, 0}, .shapes = {stroked(line({{-50, 3}, {20, 3}}), 2)}}}, 50),
      placement);
  EXPECT_NEAR(total(print.elements[0]), 90, 0.01);
  EXPECT_EQ(print.lost_mm2, 0);
  EXPECT_LT((print.elements[0].centrelines[0].curve.points.front() - Vector2d(-25, 3)).norm(), 2e-3);
}

// An element drawn about `centre`, turned by `turn` radians and moved from there on the sheet.
PlacedElement moved_element(int element, const Vector2d& centre, double turn, const Vector2d& move) {
  PlacedElement placed;
  placed.element = element;
  placed.patch = identity(14, 1);
  for (std::size_t i = 0; i < placed.patch.uv.size(); ++i) {
    placed.patch.rest[i] = Eigen::Rotation2Dd(turn) * placed.patch.uv[i] + centre + move;
    placed.patch.uv[i] += centre;
  }
  return placed;
}

TEST(VectorPrint, AJoiningLineEndsWhereItsElementsLie) {
  // Two rings that were moved apart by 2 mm each, and rotated; the line between them follows.
  Placement placement;
  placement.charts = {whole(identity(60, 2))};
  placement.elements = {moved_element(0, {-25, 0}, 0.1, {-2, 1}), moved_element(2, {25, 0}, 0.1, {2, 1})};
  const Drawing drawing = drawing_of(
      {{.id = "a", .centre = {-25, 0}, .shapes = {stroked(circle({-25, 0}, 10), 3)}},
       {.id = "",
        .centre = {0, 0},
        .shapes = {stroked(line({{-13.2, 0}, {13.2, 0}}), 1), stroked(line({{-5, 20}, {5, 20}}), 1)}},
       {.id = "b", .centre = {25, 0}, .shapes = {stroked(circle({25, 0}, 10), 3)}}});
  const VectorPrint print = pull(drawing, placement);
  const auto& lines = print.elements[1].centrelines;
  ASSERT_EQ(lines.size(), 2u);
  const Vector2d start = Eigen::Rotation2Dd(0.1) * Vector2d(11.8, 0) + Vector2d(-27, 1);
  const Vector2d end = Eigen::Rotation2Dd(0.1) * Vector2d(-11.8, 0) + Vector2d(27, 1);
  EXPECT_LT((lines[0].curve.points.front() - start).norm(), 1e-6);
  EXPECT_LT((lines[0].curve.points.back() - end).norm(), 1e-6);
  EXPECT_LT(hausdorff(lines[1].curve, points_of(line({{-5, 20}, {5, 20}}))), 1e-6);
  // The middle moves by the mean of both ends, and the line turns sharply nowhere.
  const auto points = points_of(lines[0].curve);
  EXPECT_LT(distance_to(points, {0, 1}), 1e-3);
  const auto smooth = flatten(lines[0].curve, {.tolerance_mm = 1e-4, .turn = 0.05, .longest_mm = 0.5});
  for (std::size_t i = 1; i + 1 < smooth.size(); ++i) EXPECT_GT(smooth[i].before.dot(smooth[i].after), 0.999);
  EXPECT_NEAR(total(print.elements[1]), (end - start).norm() + 10, 0.3);
}

// Two coils that lie 8 mm from where the chart has them, side by side: the line between them is as long as drawn.
TEST(VectorPrint, ALineBetweenCoilsThatMovedTogetherIsAsLongAsDrawn) {
  Placement placement;
  placement.charts = {whole(identity(60, 2))};
  placement.elements = {moved_element(0, {-12.5, 0}, 0, {3, -7.4}),
                        moved_element(2, {12.5, 0}, 0, {3, -7.4})};
  const Drawing drawing =
      drawing_of({{.id = "a", .centre = {-12.5, 0}, .shapes = {stroked(circle({-12.5, 0}, 9), 1)}},
                  {.id = "", .centre = {0, 0}, .shapes = {stroked(line({{-3.5, 0}, {3.5, 0}}), 1)}},
                  {.id = "b", .centre = {12.5, 0}, .shapes = {stroked(circle({12.5, 0}, 9), 1)}}});
  const VectorPrint print = pull(drawing, placement);
  EXPECT_NEAR(total(print.elements[1]), 7, 1e-3);
  ASSERT_EQ(print.tied.size(), 1u);
  EXPECT_EQ(print.tied[0].element, 1u);
  EXPECT_LT((print.tied[0].rest.front() - Vector2d(-0.5, -7.4)).norm(), 1e-9);
}

// The chart has a hole where the line passes: what lies on either side is a part of its own.
TEST(VectorPrint, ALineBetweenCoilsThatLeavesTheChartHasTwoParts) {
  Patch holed = identity(60, 2);
  std::erase_if(holed.triangles, [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](int v) {
      const Vector2d& p = holed.uv[static_cast<std::size_t>(v)];
      return p.x() >= -2 && p.x() <= 6 && std::abs(p.y()) <= 4;
    });
  });
  Placement placement;
  placement.charts = {whole(std::move(holed))};
  placement.elements = {moved_element(0, {-25, 0}, 0.1, {-2, 1}), moved_element(2, {25, 0}, 0.1, {2, 1})};
  const Drawing drawing =
      drawing_of({{.id = "a", .centre = {-25, 0}, .shapes = {stroked(circle({-25, 0}, 10), 3)}},
                  {.id = "", .centre = {0, 0}, .shapes = {stroked(line({{-13.2, 0}, {13.2, 0}}), 1)}},
                  {.id = "b", .centre = {25, 0}, .shapes = {stroked(circle({25, 0}, 10), 3)}}});
  const VectorPrint print = pull(drawing, placement);
  ASSERT_EQ(print.tied.size(), 2u);
  EXPECT_NEAR(print.tied[0].drawn.back().x(), -2, 0.21);
  EXPECT_NEAR(print.tied[1].drawn.front().x(), 6, 0.21);
  for (const TiedPoints& part : print.tied) EXPECT_EQ(part.drawn.size(), part.rest.size());
}

TEST(VectorPrint, TheSameBytesOnOneThreadAndOnMore) {
  Placement placement;
  placement.charts = {
      whole(patch_of({0, 0}, 50, 2, [](const Vector2d& uv) { return exponential(0.4, uv); }))};
  std::vector<Element> elements;
  for (int i = 0; i < 9; ++i) {
    const Vector2d c(15.0 * (i % 3 - 1), 15.0 * (i / 3 - 1));
    elements.push_back({.id = std::to_string(i), .centre = c, .shapes = {stroked(circle(c, 9), 2)}});
  }
  const Drawing drawing = drawing_of(elements);
  const VectorPrint a = pull(drawing, placement), b = pull(drawing, placement);
  for (std::size_t e = 0; e < 9; ++e) {
    // One element is the work of one thread.
    const VectorPrint alone = pull(drawing_of({elements[e]}), placement);
    EXPECT_EQ(a.elements[e].areas[0].outlines[0].points, b.elements[e].areas[0].outlines[0].points);
    EXPECT_EQ(a.elements[e].areas[0].outlines[0].points, alone.elements[0].areas[0].outlines[0].points);
  }
}

TEST(VectorPrint, CanBeCancelled) {
  Context context;
  context.cancel();
  const auto print = pull_back(drawing_of({}), {}, {}, context);
  ASSERT_FALSE(print);
  EXPECT_EQ(print.error().code, Code::cancelled);
}

// The area of a stroke compared with its formula.
TEST(Area, StrokesCoverWhatSvgSays) {
  Stroke s;
  s.width_mm = 4;
  const auto area = [&](const Curve& c) { return square_mm(stroke_area({c}, s, 0.001)); };
  const Curve bar = line({{0, 0}, {30, 0}}), bent = line({{0, 0}, {30, 0}, {30, 30}});
  EXPECT_NEAR(area(bar), 120, 1e-3);
  EXPECT_NEAR(area(bent), 240, 1e-3);  // 2 x 120, less the inner overlap and with the miter: the same
  s.join = LineJoin::bevel;
  EXPECT_NEAR(area(bent), 240 - 2, 1e-3);
  s.join = LineJoin::round;
  EXPECT_NEAR(area(bent), 240 - 4 + M_PI, 5e-3);
  s.cap = LineCap::round;
  EXPECT_NEAR(area(bar), 120 + M_PI * 4, 1e-2);
  EXPECT_NEAR(area(line({{5, 5}, {5, 5}})), M_PI * 4, 1e-2);
  s.cap = LineCap::square;
  EXPECT_NEAR(area(bar), 136, 1e-3);
  s.cap = LineCap::butt;
  EXPECT_NEAR(area(circle({0, 0}, 10)), M_PI * 2 * 10 * 4, 0.03);
  // Wider than the circle: a disk without a hole.
  s.width_mm = 24;
  EXPECT_NEAR(area(circle({0, 0}, 10)), M_PI * 22 * 22, 0.1);
  s.width_mm = 2;
  s.dashes_mm = {5, 3};
  s.dash_offset_mm = -1;
  EXPECT_NEAR(area(line({{0, 0}, {30, 0}})), 2 * (5 + 5 + 5 + 5), 1e-3);
  s.dashes_mm = {M_PI, M_PI};
  s.dash_offset_mm = 1;
  EXPECT_EQ(stroke_area({circle({0, 0}, 10)}, s, 0.001).size(), 10u);  // the dash over the start is one piece
}

// Points on a straight way, unevenly far apart and not quite on it: the curve never turns back between them.
TEST(CurveFit, DoesNotFoldBetweenPoints) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  for (int round = 0; round < 3000; ++round) {
    std::vector<FitPoint> points;
    double x = 0;
    const int count = 3 + round % 9;
    for (int i = 0; i < count; ++i) {
      points.push_back({{x, 0.008 * part(random)}, false});
      x += part(random) < 0.4 ? 0.05 : 0.1 + part(random);
    }
    const Curve curve = fit_curve(points, false, 0.01);
    double farthest = 0;
    for (std::size_t k = 0; k + 3 < curve.points.size(); k += 3)
      for (int step = 0; step <= 50; ++step) {
        const double t = step / 50.0, s = 1 - t;
        const double at = s * s * s * curve.points[k].x() + 3 * s * s * t * curve.points[k + 1].x() +
                          3 * s * t * t * curve.points[k + 2].x() + t * t * t * curve.points[k + 3].x();
        ASSERT_GE(at, farthest - 1e-3) << "round " << round;
        farthest = std::max(farthest, at);
      }
  }
}

TEST(CurveFit, FollowsACircleWithFewSegments) {
  std::vector<FitPoint> points;
  for (int i = 0; i < 700; ++i) {
    const double a = 2 * M_PI * i / 700;
    points.push_back({{20 * std::cos(a), 20 * std::sin(a)}, false});
  }
  const Curve curve = fit_curve(points, true, 0.01);
  EXPECT_LE(curve.points.size(), 3 * 12 + 1u);
  for (const Vector2d& p : points_of(curve)) EXPECT_NEAR(p.norm(), 20, 0.0105);
  EXPECT_TRUE(fit_curve({}, true, 0.01).points.empty());
  EXPECT_TRUE(fit_curve({{{1, 1}, true}, {{1, 1}, false}}, false, 0.01).points.empty());
}

// A black page over a dome in segments, whose coordinates jump at the seams. The sheet has neither gaps nor overlaps:
// the painted area equals the sheet's area, and its holes are narrower than a tenth of a millimetre.
TEST(VectorPrint, SegmentsMeetOnTheSheet) {
  const Patch dome = patch_of({0, 0}, 40, 2, [](const Vector2d& uv) { return exponential(0, uv); });
  const auto cut = cut_into_segments(dome, 1, 1.02, {}, Context{});
  ASSERT_TRUE(cut);
  ASSERT_GT(cut->parts.size(), 1u);
  Placement placement;
  placement.charts = cut->parts;
  placement.seams = cut->seams;
  Drawing page;
  page.size_mm = {200, 200};
  Curve square{{}, true};
  const std::array<Vector2d, 4> corners{Vector2d(-99, -99), Vector2d(99, -99), Vector2d(99, 99),
                                        Vector2d(-99, 99)};
  square.points.push_back(corners[0]);
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector2d &a = corners[k], &b = corners[(k + 1) % 4];
    square.points.insert(square.points.end(), {a + (b - a) / 3, b - (b - a) / 3, b});
  }
  Shape black;
  black.curves = {square};
  black.fill = Colour{};
  page.elements.push_back({"", {0, 0}, {black}});
  const auto print = pull_back(page, placement, Settings(), Context());
  ASSERT_TRUE(print);
  ASSERT_EQ(print->elements[0].areas.size(), 1u);  // one area: no gap between its pieces
  const PaintedArea& area = print->elements[0].areas[0];
  ASSERT_EQ(area.outlines.size(), cut->parts.size());

  double sheet = 0;
  for (const Triangle& t : dome.triangles) {
    const auto at = [&](std::size_t k) { return dome.rest[static_cast<std::size_t>(t[k])]; };
    const Vector2d a = at(1) - at(0), b = at(2) - at(0);
    sheet += (a.x() * b.y() - a.y() * b.x()) / 2;
  }
  double pieces = 0, seams = 0;
  std::vector<Ring> rings;
  for (const Curve& outline : area.outlines) {
    rings.emplace_back();
    for (const CurvePoint& p : flatten(outline, {.tolerance_mm = 0.0005, .turn = 0.1, .longest_mm = 1}))
      rings.back().push_back(p.at);
    rings.back().pop_back();
    pieces += square_mm(union_of({rings.back()}));
  }
  for (const Seam& seam : cut->seams) seams += seam.length_mm;
  const double together = square_mm(union_of(rings));
  EXPECT_LT((pieces - together) / seams, 0.002);  // covered twice, mean width in mm along the seams
  EXPECT_LT((sheet - together) / seams, 0.002);   // not covered
  // If a ring of 0.05 mm around each piece is ink too, no hole is left.
  std::vector<Curve> lines;
  for (const Ring& ring : rings) {
    Curve line{{ring[0]}, true};
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vector2d &a = ring[k], &b = ring[(k + 1) % ring.size()];
      line.points.insert(line.points.end(), {a + (b - a) / 3, b - (b - a) / 3, b});
    }
    lines.push_back(std::move(line));
  }
  Stroke stroke;
  stroke.width_mm = 0.1;
  const Area border = stroke_area(lines, stroke, 0.002);
  std::vector<Ring> all = rings;
  all.insert(all.end(), border.begin(), border.end());
  EXPECT_EQ(union_of(all).size(), 1u);
  for (const double gap : seam_gaps(placement)) EXPECT_LT(gap, 1e-6);
}

}  // namespace
}  // namespace vacuform
