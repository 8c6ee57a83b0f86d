#include "worker/inspection/coil_figures.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/inspection/loop_figures.hpp"
#include "worker/inspection/stretched_traces.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/pattern/sorting.hpp"
#include "worker/placement/outline.hpp"

namespace vacuform::coil_figures_test {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using hand_made::Sample;

std::vector<Vector2d> circle(const Vector2d& centre, double radius, int points = 720) {
  std::vector<Vector2d> line;
  for (int i = 0; i < points; ++i) {
    const double a = 2 * M_PI * i / points;
    line.push_back(centre + radius * Vector2d(std::cos(a), std::sin(a)));
  }
  return line;
}

// Four cubics: within 3e-4 of the radius.
Curve bezier_circle(const Vector2d& centre, double radius) {
  const double handle = 0.5522847498;
  Curve curve{.points = {}, .closed = true};
  for (int i = 0; i < 4; ++i) {
    const Matrix2d turn = Eigen::Rotation2Dd(i * M_PI / 2).toRotationMatrix();
    for (const Vector2d& p : {Vector2d(1, 0), Vector2d(1, handle), Vector2d(handle, 1)})
      curve.points.push_back(centre + radius * (turn * p));
  }
  curve.points.push_back(curve.points.front());
  return curve;
}

// The dome of hand_made: polar angle by distance from the middle of the flat sheet.
constexpr double radius = 60, steepest = 80 * M_PI / 180, reach = 70;
Vector3d on_dome(const Vector2d& rest) {
  const double a = steepest * rest.norm() / reach, b = std::atan2(rest.y(), rest.x());
  return radius * Vector3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
}
Vector2d to_rest(const Vector3d& place) {
  const double a = std::acos(place.z() / radius), b = std::atan2(place.y(), place.x());
  return reach * a / steepest * Vector2d(std::cos(b), std::sin(b));
}
// The geodesic circle about the point that a place of the flat sheet becomes, as it lies on the flat sheet.
std::vector<Vector2d> circle_on_dome(const Vector2d& centre_rest, double geodesic_radius) {
  const Vector3d c = on_dome(centre_rest).normalized(), u = c.unitOrthogonal(), v = c.cross(u);
  const double a = geodesic_radius / radius;
  std::vector<Vector2d> line;
  for (int i = 0; i < 720; ++i) {
    const double b = 2 * M_PI * i / 720;
    line.push_back(to_rest(radius * (std::cos(a) * c + std::sin(a) * (std::cos(b) * u + std::sin(b) * v))));
  }
  return line;
}

TEST(LoopFigures, MatchACircleOnAFlatSheet) {
  const Sample x = hand_made::flat(200, 50);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  const auto loop = measure_loop(sheet, circle({7, -3}, 20), {9, -2});
  ASSERT_TRUE(loop);
  EXPECT_NEAR(loop->diameter_mm, 40, 0.001);
  EXPECT_LT(loop->circularity, 1e-4);
  EXPECT_NEAR(loop->area_mm2, 400 * M_PI, 0.1);
  EXPECT_NEAR(loop->worst_stretch, 1, 1e-9);
  EXPECT_LT((loop->centre_rest - Vector2d(7, -3)).norm(), 1e-3);
  EXPECT_TRUE(loop->on_head);
  const PlaneLoopFigures plane = measure_plane_loop(circle({7, -3}, 20));
  EXPECT_NEAR(plane.diameter_mm, 40, 0.001);
  EXPECT_LT(plane.circularity, 1e-5);
  EXPECT_LT((plane.centre - Vector2d(7, -3)).norm(), 1e-6);
}

TEST(LoopFigures, MatchTheEllipseOfAStretchedCircle) {
  Matrix2d stretch;
  stretch << 1.2, 0, 0, 0.9;
  const Sample x = hand_made::stretched(200, 50, stretch);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  const auto loop = measure_loop(sheet, circle({5, 5}, 20), {5, 5});
  ASSERT_TRUE(loop);
  std::vector<Vector2d> ellipse = circle({5, 5}, 20, 2000);
  double length = 0, sum = 0;
  for (Vector2d& p : ellipse) p = stretch * p;
  for (std::size_t i = 0; i < ellipse.size(); ++i) {
    const Vector2d a = ellipse[i] - stretch * Vector2d(5, 5);
    const double piece = (ellipse[(i + 1) % ellipse.size()] - ellipse[i]).norm();
    length += piece, sum += piece * a.norm();
  }
  const double mean = sum / length;
  EXPECT_NEAR(loop->diameter_mm, 2 * mean, 0.005);
  EXPECT_NEAR(loop->circularity, std::max(24 - mean, mean - 18) / mean, 0.0005);
  EXPECT_NEAR(loop->area_mm2, 1.08 * 400 * M_PI, 0.1);
  EXPECT_NEAR(loop->worst_stretch, 1.2, 0.001);
}

// Geodesic circles of a sphere: the polyhedron of 3 mm edges is inside of it by at most 3^2 / (8 60) mm.
TEST(LoopFigures, AreExactForGeodesicCirclesOnADome) {
  const Sample x = hand_made::dome(100);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  for (const Vector2d& centre : {Vector2d(0, 0), Vector2d(25, 10), Vector2d(-10, -32)})
    for (const double r : {15.0, 20.0}) {
      const auto loop = measure_loop(sheet, circle_on_dome(centre, r), centre + Vector2d(2, -1));
      ASSERT_TRUE(loop);
      EXPECT_NEAR(loop->diameter_mm / (2 * r), 1, 0.002);
      EXPECT_LT(loop->circularity, 0.003);
      EXPECT_LT((loop->centre_rest - centre).norm(), 0.05);
      EXPECT_LT((loop->centre - on_dome(centre)).norm(), 0.1);
      EXPECT_NEAR(loop->area_mm2 / (2 * M_PI * radius * radius * (1 - std::cos(r / radius))), 1, 0.004);
      EXPECT_TRUE(loop->on_head);
    }
  // Around the top: the parallel at 40 degrees is 60 sin 40 / 35 times as long as it was.
  const auto parallel = measure_loop(sheet, circle({0, 0}, 35), {0, 0});
  ASSERT_TRUE(parallel);
  EXPECT_NEAR(parallel->diameter_mm, 2 * radius * 40 * M_PI / 180, 0.1);
  EXPECT_NEAR(parallel->worst_stretch, radius * std::sin(40 * M_PI / 180) / 35, 0.015);
}

TEST(LoopFigures, TheShortestWayOverADomeIsTheGreatCircle) {
  const Sample x = hand_made::dome(100);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  const Vector2d a(35, 12), b(-20, 30);
  const double angle = std::acos(on_dome(a).dot(on_dome(b)) / radius / radius);
  EXPECT_NEAR(geodesic_distance(sheet, a, b), radius * angle, 0.05);
  EXPECT_LT(geodesic_distance(sheet, a, a), 1e-4);
  EXPECT_TRUE(std::isnan(geodesic_distance(sheet, a, {500, 0})));
}

TEST(LoopFigures, OffTheChartOrTheSheetAreSaidToBe) {
  const Sample x = hand_made::dome(60);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  const auto beyond = measure_loop(sheet, circle({60, 0}, 20), {60, 0});
  ASSERT_TRUE(beyond);
  EXPECT_FALSE(beyond->on_head);
  EXPECT_FALSE(measure_loop(sheet, circle({140, 0}, 20), {140, 0}));
  EXPECT_FALSE(measure_loop(sheet, {}, {0, 0}));
  EXPECT_FALSE(measure_loop(sheet, {Vector2d(NAN, 0), Vector2d(1, 0), Vector2d(0, 1)}, {0, 0}));
}

// Two 20 mm circles, 15 mm apart, and one far off; a line that is in no element.
Drawing drawing() {
  Drawing out{{60, 50}, {}};
  const Stroke stroke{.colour = {}, .width_mm = 2, .dashes_mm = {}};
  const auto ring = [&](const std::string& id, const Vector2d& centre) {
    Shape shape;
    shape.curves = {bezier_circle(centre, 3), bezier_circle(centre, 10)};
    shape.stroke = stroke;
    return one_element(id, {shape});
  };
  out.elements = {ring("left", {-7.5, 0}), ring("right", {7.5, 0}), ring("", {0, 0}), ring("far", {90, 0})};
  return out;
}

struct Coils {
  Sample sample;
  Drawing drawn = drawing();
  VectorPrint print;
  Placement placement;
  Alignment alignment;
  std::vector<CoilLoops> loops;
  std::vector<NeighbourLoops> pairs;

  explicit Coils(Sample made) : sample(std::move(made)) {}
  void prepare() {
    loops = coil_loops(drawn, placement, print, sample.flattening, alignment);
    pairs = neighbours(loops, placement, drawn);
  }
  CoilTable measure() {
    prepare();
    return *measure_coils({MeasuredSheet(hand_made::Charted(sample))}, loops, pairs, {}, Context());
  }
};

// The sheet is stretched by 1.25 both ways. The print makes it good for the left coil, and is a tenth too small for the
// right one.
Coils stretched_coils() {
  Coils coils(hand_made::stretched(160, 40, 1.25 * Matrix2d::Identity()));
  const auto printed = [](const std::string& id, const Vector2d& at, double r) {
    return PrintedElement{
        id, {}, {{bezier_circle(at / 1.25, 3 / 1.25), 2}}, bezier_circle(at / 1.25, r / 1.25)};
  };
  coils.print.elements = {printed("left", {-7.5, 0}, 10), printed("right", {7.5, 0}, 9)};
  return coils;
}

TEST(CoilFigures, CompareThePrintAndThePlainDrawingWithTheDrawing) {
  Coils coils = stretched_coils();
  const CoilTable table = coils.measure();
  ASSERT_EQ(table.coils.size(), 3u);
  const Coil &left = table.coils[0], &right = table.coils[1], &far = table.coils[2];
  EXPECT_EQ(left.id, "left");
  EXPECT_NEAR(left.drawn_diameter_mm, 20, 0.01);
  EXPECT_NEAR(left.drawn_area_mm2, 100 * M_PI, 0.2);
  EXPECT_LT(left.drawn_circularity, 4e-4);
  ASSERT_TRUE(left.with && left.without && right.with && right.without);
  EXPECT_NEAR(left.with->diameter_error, 0, 1e-4);
  EXPECT_NEAR(left.with->area_error, 0, 1e-4);
  EXPECT_NEAR(right.with->diameter_error, -0.1, 1e-4);
  EXPECT_NEAR(right.with->area_error, 0.81 - 1, 1e-4);
  for (const Coil* coil : {&left, &right}) {
    EXPECT_NEAR(coil->without->diameter_error, 0.25, 1e-4);
    EXPECT_NEAR(coil->without->area_error, 1.5625 - 1, 1e-4);
    EXPECT_NEAR(coil->without->worst_stretch, 1.25, 1e-3);
    EXPECT_LT(coil->with->circularity, 5e-4);
  }
  EXPECT_FALSE(far.with);     // not on the print
  EXPECT_FALSE(far.without);  // off the sheet
  ASSERT_EQ(table.pairs.size(), 1u);
  const CoilPair& pair = table.pairs[0];
  EXPECT_EQ(std::pair(pair.a, pair.b), std::pair(0, 1));
  EXPECT_NEAR(pair.drawn_mm, 15, 1e-3);
  EXPECT_NEAR(pair.drawn_overlap_mm, 5, 0.01);
  EXPECT_NEAR(pair.with->mm, 15, 0.01);
  EXPECT_NEAR(pair.with->overlap_mm, 4, 0.02);
  EXPECT_NEAR(pair.without->mm, 18.75, 0.01);
  EXPECT_NEAR(pair.without->overlap_mm, 6.25, 0.02);
  EXPECT_EQ(table.with.coils, 2);
  EXPECT_NEAR(table.with.mean_diameter_error, 0.05, 1e-4);
  EXPECT_NEAR(table.with.worst_area_error, 0.19, 1e-4);
  EXPECT_NEAR(table.with.spacing_rms_mm, 0, 0.01);
  EXPECT_NEAR(table.without.spacing_rms_mm, 3.75, 0.01);
  // mu0 a [ln(8 a / b) - 2], b a quarter of the strip's width; of coplanar loops 0.758 diameters apart, M is 0.
  EXPECT_NEAR(*left.with->inductance_nh, 0.4 * M_PI * 10 * (std::log(80 / 0.5) - 2), 0.5);
  EXPECT_NEAR(*pair.with->k, 0, 0.02);
  ASSERT_TRUE(table.with.strongest_neighbours && table.with.strongest);
  EXPECT_EQ(table.with.strongest_neighbours->k, *pair.with->k);
  EXPECT_EQ(table.with.strongest_neighbours->mm, pair.with->mm);
  EXPECT_EQ(table.with.strongest->k, *pair.with->k);
}

// Four coils about a vertex each, where grid lines and diagonals meet.
TEST(CoilFigures, AreFoundAboutAVertexOfTheSheet) {
  const Sample x = hand_made::flat(160, 40);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  for (const Vector2d& vertex : {Vector2d(0, 0), Vector2d(4, 0), Vector2d(-8, 12), Vector2d(20, -4)})
    for (const double r : {10.0, 20.0, 33.0}) {
      const auto loop = measure_loop(sheet, circle(vertex, r), vertex);
      ASSERT_TRUE(loop) << vertex.transpose() << " radius " << r;
      EXPECT_NEAR(loop->diameter_mm, 2 * r, 1e-3);
      EXPECT_LT(loop->circularity, 1e-4);
    }
}

// Whichever way round a loop is drawn, loops apart in a plane have a negative coupling and loops that overlap much a
// positive one.
TEST(CoilFigures, TheSignOfACouplingIsThatOfTheOverlap) {
  Coils coils(hand_made::flat(160, 40));
  auto& turned = coils.drawn.elements[1].loop->line;
  std::reverse(turned.begin(), turned.end());
  EXPECT_NEAR(*coils.measure().pairs[0].without->k, 0, 0.02);
  for (auto& p : turned) p.x() -= 5;
  EXPECT_GT(*coils.measure().pairs[0].without->k, 0.1);
  for (auto& p : turned) p.x() += 12;
  EXPECT_LT(*coils.measure().pairs[0].without->k, -0.01);
}

TEST(CoilFigures, KnowTheSizesThatDecouplingGave) {
  Coils coils = stretched_coils();
  coils.placement.elements.resize(2);
  coils.placement.elements[1].element = 1;
  coils.placement.elements[1].size = 0.9;
  coils.placement.elements[1].centre_rest = {6, 0};
  coils.placement.elements[0].centre_rest = {-6, 0};
  coils.placement.pairs.resize(1);
  coils.placement.pairs[0].b = 1;
  const CoilTable table = coils.measure();
  EXPECT_NEAR(table.coils[1].size, 0.9, 1e-12);
  EXPECT_NEAR(table.coils[1].with->diameter_error, 0, 1e-4);
  EXPECT_NEAR(table.coils[1].with->area_error, 0, 1e-4);
  EXPECT_NEAR(table.coils[1].without->diameter_error, 0.25, 1e-4);
  EXPECT_EQ(table.pairs.size(), 1u);
}

TEST(CoilFigures, FollowScaleTurnAndOffsetOfThePattern) {
  Coils coils(hand_made::flat(160, 40));
  coils.alignment = {.turn_deg = 90, .scale = 1.5, .shift_mm = {4, -6}};
  coils.sample.flattening.top_rest = {1, 2};
  const CoilTable table = coils.measure();
  ASSERT_TRUE(table.coils[0].without);
  EXPECT_NEAR(table.coils[0].without->diameter_mm, 30, 0.02);
  EXPECT_NEAR(table.coils[0].without->diameter_error, 0, 5e-4);
  // (-7.5, 0) at one and a half its size, turned a quarter to the left, from (5, -4).
  EXPECT_LT((table.coils[0].without->centre - Vector3d(5, -4 - 11.25, 0)).norm(), 0.02);
  EXPECT_NEAR(table.pairs[0].drawn_mm, 22.5, 1e-3);
  EXPECT_NEAR(table.pairs[0].without->mm, 22.5, 0.02);
}

TEST(CoilFigures, AreTheSameTwiceAndCanBeCancelled) {
  Coils coils = stretched_coils();
  const CoilTable a = coils.measure(), b = coils.measure();
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(a.coils[i].with->circularity, b.coils[i].with->circularity);
    EXPECT_EQ(a.coils[i].with->centre, b.coils[i].with->centre);
  }
  Context context;
  context.cancel();
  const auto cancelled =
      measure_coils({MeasuredSheet(hand_made::Charted(coils.sample))}, coils.loops, coils.pairs, {}, context);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, Code::cancelled);
}

Curve straight(const Vector2d& a, const Vector2d& b) {
  return {.points = {a, a + (b - a) / 3, a + 2 * (b - a) / 3, b}, .closed = false};
}

// An arc by cubics of at most 15 degrees.
Curve arc(const Vector2d& centre, double r, double from_deg, double to_deg) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(to_deg - from_deg) / 15)));
  const double step = (to_deg - from_deg) / pieces * M_PI / 180, handle = 4.0 / 3 * std::tan(step / 4);
  Curve curve{.points = {}, .closed = false};
  for (int i = 0; i <= pieces; ++i) {
    const double a = from_deg * M_PI / 180 + i * step;
    const Vector2d out(std::cos(a), std::sin(a)), along(-out.y(), out.x());
    if (i > 0) curve.points.push_back(centre + r * (out - handle * along));
    curve.points.push_back(centre + r * out);
    if (i < pieces) curve.points.push_back(centre + r * (out + handle * along));
  }
  return curve;
}
Curve full_circle(const Vector2d& centre, double r) {
  Curve curve = arc(centre, r, 0, 360);
  curve.points.back() = curve.points.front();
  curve.closed = true;
  return curve;
}
Element drawn_with(const std::vector<Curve>& curves, bool filled, bool even_odd = true) {
  Shape shape;
  shape.curves = curves;
  if (filled)
    shape.fill = Colour{}, shape.even_odd = even_odd;
  else
    shape.stroke = Stroke{.colour = {}, .width_mm = 3, .dashes_mm = {}};
  return one_element("coil", {shape});
}

// Straight pieces from point to point.
Curve through(const std::vector<Vector2d>& line) {
  Curve out{{line.front()}, true};
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector2d &a = line[i], &b = line[(i + 1) % line.size()];
    out.points.insert(out.points.end(), {a + (b - a) / 3, b - (b - a) / 3, b});
  }
  return out;
}

// On the dome, printed as it is drawn.
CoilTable on_the_dome(const Element& element) {
  Coils coils(hand_made::dome(100));
  coils.drawn = {{200, 200}, {element}};
  coils.print.elements = {{"coil", {}, {}, {}}};
  if (element.loop) coils.print.elements[0].loop = through(element.loop->line);
  return coils.measure();
}

// The bound of a straight piece across a gap g of a circle of radius r is its sagitta, g^2 / (8 r) of 20 mm.
void expect_same(const CoilTable& one, const CoilTable& other, double bound) {
  ASSERT_EQ(one.coils.size(), 1u);
  ASSERT_EQ(other.coils.size(), 1u);
  const Coil &a = one.coils[0], &b = other.coils[0];
  EXPECT_NEAR(a.drawn_diameter_mm / b.drawn_diameter_mm, 1, bound);
  EXPECT_NEAR(a.drawn_area_mm2 / b.drawn_area_mm2, 1, bound);
  EXPECT_NEAR(a.drawn_circularity, b.drawn_circularity, bound);
  for (const Way way : both_ways) {
    ASSERT_TRUE(a[way] && b[way]);
    EXPECT_NEAR(a[way]->circularity, b[way]->circularity, bound);
    EXPECT_NEAR(a[way]->diameter_mm / b[way]->diameter_mm, 1, bound);
    EXPECT_NEAR(a[way]->area_mm2 / b[way]->area_mm2, 1, bound);
    EXPECT_NEAR(*a[way]->inductance_nh / *b[way]->inductance_nh, 1, 0.005);
  }
}

const Vector2d at(10, 5);

TEST(CoilFigures, MeasureTheLineBetweenTheEdgesOfAFilledRing) {
  const CoilTable plain = on_the_dome(drawn_with({full_circle(at, 20)}, false));
  expect_same(on_the_dome(drawn_with({full_circle(at, 18.5), full_circle(at, 21.5)}, true)), plain, 0.001);
  Curve turned = full_circle(at, 18.5);
  std::reverse(turned.points.begin(), turned.points.end());
  expect_same(on_the_dome(drawn_with({full_circle(at, 21.5), turned}, true, false)), plain, 0.001);
}

TEST(CoilFigures, AreTheSameForALineWithGapsAndAWholeOne) {
  const CoilTable plain = on_the_dome(drawn_with({full_circle(at, 20)}, false));
  const double half = 0.75 / 20 * 180 / M_PI;  // of a gap of 1.5 mm, in degrees
  expect_same(on_the_dome(drawn_with({arc(at, 20, half, 360 - half)}, false)), plain, 0.001);
  // Four capacitors, arcs out of order and drawn either way.
  std::vector<Curve> arcs;
  for (const int k : {2, 0, 3, 1}) {
    arcs.push_back(arc(at, 20, 90 * k + half, 90 * (k + 1) - half));
    if (k % 2 == 1) std::reverse(arcs.back().points.begin(), arcs.back().points.end());
  }
  expect_same(on_the_dome(drawn_with(arcs, false)), plain, 0.001);
  // Leads at the feed are left over.
  std::vector<Curve> fed{arc(at, 20, half, 360 - half)};
  for (const double y : {-0.75, 0.75})
    fed.push_back(straight(at + Vector2d(std::sqrt(400 - 0.5625), y), at + Vector2d(30, y)));
  expect_same(on_the_dome(drawn_with(fed, false)), plain, 0.001);
}

TEST(CoilFigures, AreNotOfOtherFigures) {
  const auto coils = [](const Element& element) { return on_the_dome(element).coils.size(); };
  EXPECT_EQ(coils(drawn_with({arc(at, 20, 0, 302)}, false)), 0u);  // 15 % is missing from 304 on
  EXPECT_EQ(coils(drawn_with({arc(at, 20, 0, 306)}, false)), 1u);
  EXPECT_EQ(coils(drawn_with({arc(at, 20, 0, 200)}, false)), 0u);
  EXPECT_EQ(coils(drawn_with({arc(at, 20, 0, 100), arc(at, 20, 130, 200)}, false)), 0u);
  std::vector<Curve> zigzag, hairpin;
  for (int i = 0; i < 8; ++i)
    zigzag.push_back(straight({i * 4.0, i % 2 * 20.0}, {i * 4.0 + 4, (i + 1) % 2 * 20.0}));
  EXPECT_EQ(coils(drawn_with(zigzag, false)), 0u);
  hairpin = {straight({0, 0}, {40, 0}), straight({40, 0}, {40, 2}), straight({40, 2}, {0, 2})};
  EXPECT_EQ(coils(drawn_with(hairpin, false)), 0u);
  // A disc, a disc with a small hole, a ring that is far wider on one side, two discs side by side.
  EXPECT_EQ(coils(drawn_with({full_circle(at, 20)}, true)), 0u);
  EXPECT_EQ(coils(drawn_with({full_circle(at, 20), full_circle(at, 8)}, true)), 0u);
  EXPECT_EQ(coils(drawn_with({full_circle(at, 20), full_circle(at + Vector2d(2.5, 0), 16)}, true)), 0u);
  EXPECT_EQ(coils(drawn_with({full_circle(at, 10), full_circle(at + Vector2d(25, 0), 9)}, true)), 0u);
}

TEST(CoilFigures, AreOfTheLoopThatPlacementSees) {
  const double half = 0.75 / 20 * 180 / M_PI;
  for (const Element& element : {drawn_with({arc(at, 20, half, 360 - half)}, false),
                                 drawn_with({full_circle(at, 21.5), full_circle(at, 18.5)}, true)}) {
    const Outline seen = outline(element, 2);
    EXPECT_NEAR(seen.radius_mm, 40, 0.01);
    EXPECT_NEAR(seen.width_mm, 6, 0.01);
    ASSERT_EQ(seen.loop.size(), 96u);
    EXPECT_GT(signed_area(seen.loop), 0);
    for (const Vector2d& p : seen.loop) EXPECT_NEAR(p.norm(), 40, 0.04);
  }
  EXPECT_FALSE(outline(drawn_with({arc(at, 20, 0, 200)}, false), 1).is_loop());
}

// What the border leaves of a loop is not one with a gap.
TEST(CoilFigures, AreOfPrintsThatHaveTheWholeLoop) {
  Coils coils(hand_made::dome(100));
  coils.drawn = {{200, 200}, {drawn_with({full_circle(at, 20)}, false)}};
  coils.print.elements = {{"coil", {}, {{arc(at, 20, 10, 350), 3}}, {}}};
  EXPECT_FALSE(coils.measure().coils[0].with);
  coils.print.elements[0].loop = full_circle(at, 20);
  EXPECT_TRUE(coils.measure().coils[0].with);
}

// A sheet that became 1.3 times as wide: lines along s are stretched, lines along t are not, circles at two places.
TEST(StretchedTraces, AreThoseAlongTheStretch) {
  Matrix2d stretch;
  stretch << 1.3, 0, 0, 1;
  const Sample x = hand_made::stretched(200, 40, stretch);
  VectorPrint print;
  print.elements = {{"along", {}, {{straight({-10, 50}, {30, 50}), 1}}, {}},
                    {"across", {}, {{straight({50, -20}, {50, 20}), 1}}, {}},
                    {"ring", {}, {{bezier_circle({0, 0}, 20), 1}}, {}},
                    {"", {}, {{straight({60, 0}, {70, 0}), 1}, {straight({60, 9}, {70, 9}), 1}}, {}},
                    {"off", {}, {{straight({300, 0}, {320, 0}), 1}}, {}}};
  const TraceFigures figures = measure_traces(MeasuredSheet(hand_made::Charted(x)), print, 0.2);
  EXPECT_EQ(figures.traces, 4);
  EXPECT_NEAR(figures.worst_stretch, 1.3, 1e-9);
  ASSERT_EQ(figures.stretched.size(), 3u);
  const auto of = [&](const std::string& id) {
    return *std::find_if(figures.stretched.begin(), figures.stretched.end(),
                         [&](const StretchedTrace& trace) { return trace.id == id; });
  };
  EXPECT_NEAR(of("along").stretched_mm, 52, 1e-6);
  EXPECT_NEAR(of("along").length_mm, 52, 1e-6);
  ASSERT_EQ(of("along").marks.size(), 1u);
  EXPECT_NEAR(of("along").marks[0].size_mm, 52, 1e-6);
  EXPECT_NEAR(of("along").worst_place.y(), 50, 1e-6);
  EXPECT_EQ(of("").marks.size(), 2u);
  // Tangents within acos sqrt(0.44 / 0.69) = 37 degrees of the s axis: 37 of 90 degrees of the ring, above and below.
  // A ring is cut where it begins, on its right, where nothing is stretched.
  EXPECT_EQ(of("ring").marks.size(), 2u);
  EXPECT_NEAR(of("ring").worst_stretch, 1.3, 1e-3);
  EXPECT_NEAR(std::abs(of("ring").worst_place.y()), 20, 0.2);
  EXPECT_NEAR(of("ring").marks[0].size_mm, 1.3 * 40 * std::sin(37.0 * M_PI / 180), 3);
  ASSERT_EQ(figures.warnings.size(), 1u);
  EXPECT_EQ(figures.warnings[0].code, "trace-stretched");
  EXPECT_EQ(figures.warnings[0].marks.size(), 5u);
  EXPECT_EQ(figures.warnings[0].text.find("3 of 4 traces are stretched by more than the 20 %"), 0u);
  EXPECT_NE(figures.warnings[0].text.find("by 30 %"), std::string::npos);

  const TraceFigures enough = measure_traces(MeasuredSheet(hand_made::Charted(x)), print, 0.31);
  EXPECT_TRUE(enough.stretched.empty() && enough.warnings.empty());
  EXPECT_EQ(measure_traces(MeasuredSheet(hand_made::Charted(x)), {}, 0.2).traces, 0);
}

}  // namespace
}  // namespace vacuform::coil_figures_test
