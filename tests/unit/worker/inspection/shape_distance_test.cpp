#include "worker/inspection/shape_distance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/inspection/coil_warnings.hpp"
#include "worker/inspection/loop_figures.hpp"

namespace vacuform::shape_distance_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Line = std::vector<Vector2d>;

Line ellipse(double a, double b, int points = 720) {
  Line line;
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * M_PI * i / points;
    line.emplace_back(a * std::cos(angle), b * std::sin(angle));
  }
  return line;
}
Line hexagon(double radius) { return ellipse(radius, radius, 6); }

Line moved(Line line, double degrees, const Vector2d& shift, std::size_t begin) {
  for (Vector2d& p : line) p = Eigen::Rotation2Dd(degrees * M_PI / 180) * p + shift;
  std::rotate(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(begin), line.end());
  return line;
}

TEST(ShapeDistance, IsZeroAfterATurnAndAShift) {
  for (const Line& shape : {ellipse(30, 20), ellipse(20, 20), hexagon(25), Line{{0, 0}, {40, 0}, {30, 25}}}) {
    const ShapeDistance d = shape_distance(moved(shape, 73, {14, -9}, shape.size() / 3), shape);
    EXPECT_LT(d.largest_mm, 0.02);
    EXPECT_LT(d.mean_mm, 0.01);
  }
}

TEST(ShapeDistance, CountsAWrongSize) {
  const ShapeDistance d = shape_distance(moved(ellipse(20.5, 20.5), 10, {3, 4}, 5), ellipse(20, 20));
  EXPECT_NEAR(d.largest_mm, 0.5, 0.005);
  EXPECT_NEAR(d.mean_mm, 0.5, 0.005);
}

TEST(ShapeDistance, FindsWhatOnlyOneOfTheLinesHas) {
  Line dented = ellipse(20, 20);
  dented[100] *= 0.9;
  EXPECT_NEAR(shape_distance(dented, ellipse(20, 20)).largest_mm, 2, 0.1);  // the fit takes a little
  EXPECT_NEAR(shape_distance(ellipse(20, 20), dented).largest_mm, 2, 0.3);
  EXPECT_NEAR(shape_distance(ellipse(30.6, 20), ellipse(30, 20)).largest_mm, 0.6, 0.05);
}

TEST(ShapeDistance, IsInfiniteWithoutALine) {
  EXPECT_EQ(shape_distance({}, hexagon(3)).largest_mm, INFINITY);
}

// Lambert's map takes the ellipse to a sphere of 60 mm: its geodesic polar coordinates come back as the ellipse.
TEST(TrueToArea, TakesALoopOfASphereBackToItsDrawing) {
  constexpr double radius = 60;
  const Line drawn = ellipse(30, 20);
  Line polar = drawn;
  for (Vector2d& p : polar) p *= 2 * radius * std::asin(p.norm() / 2 / radius) / p.norm();
  EXPECT_GT(shape_distance(polar, drawn).largest_mm, 0.2);
  const Line back = true_to_area(polar, 600 * M_PI);
  for (std::size_t i = 0; i < back.size(); ++i) EXPECT_LT((back[i] - drawn[i]).norm(), 0.005);
  EXPECT_EQ(true_to_area(drawn, 0), drawn);
}

// The dome of hand_made: polar angle by distance from the middle of the flat sheet.
TEST(LoopFigures, EllipsesAndHexagonsOnADomeKeepTheirShape) {
  constexpr double radius = 60, steepest = 80 * M_PI / 180, reach = 70;
  const auto x = hand_made::dome(100);
  const hand_made::Charted charted(x);
  const MeasuredSheet sheet(charted);
  const Vector3d c = Vector3d(0.3, 0.2, 1).normalized(), u = c.unitOrthogonal(), v = c.cross(u);
  const auto rest = [&](const Vector3d& place) -> Vector2d {
    const double a = std::acos(place.z()), b = std::atan2(place.y(), place.x());
    return reach * a / steepest * Vector2d(std::cos(b), std::sin(b));
  };
  Line six;  // with points between its corners, as it is bent on the sphere
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 40; ++k)
      six.push_back(hexagon(18)[static_cast<std::size_t>(i)] * (1 - k / 40.0) +
                    hexagon(18)[static_cast<std::size_t>((i + 1) % 6)] * (k / 40.0));
  for (const Line& drawn : {ellipse(22, 15), six}) {
    Line line;
    for (const Vector2d& p : drawn) {
      const double a = 2 * std::asin(p.norm() / 2 / radius);
      line.push_back(rest(std::cos(a) * c + std::sin(a) * (p.x() * u + p.y() * v) / p.norm()));
    }
    const auto loop = measure_loop(sheet, line, rest(c));
    ASSERT_TRUE(loop);
    EXPECT_GT(loop->circularity, 0.06);  // far from a circle
    const ShapeDistance d = shape_distance(loop->shape, drawn);
    EXPECT_LT(d.largest_mm, 0.06);
    EXPECT_LT(d.mean_mm, 0.03);
  }
}

Coil coil(const std::string& id, double shape_error, bool on_head = true, bool smooth = true) {
  Coil out;
  out.id = id;
  out.drawn_diameter_mm = 40;
  out.smooth = smooth;
  out.with.emplace();
  out.with->on_head = on_head;
  out.with->shape_error = shape_error;
  out.with->shape.largest_mm = 40 * shape_error;
  return out;
}

TEST(CoilWarnings, AreSilentAboutCoilsOnBumpsThatComeOutRight) {
  CoilTable table;
  table.coils = {coil("a", 0.001, true, false), coil("b", 0.2, false)};
  table.with.coils = 1;
  EXPECT_TRUE(coil_warnings(table, false).empty());
}

TEST(CoilWarnings, NameTheCoilsThatComeOutOfShapeWithFigureAndPlace) {
  CoilTable table;
  table.coils = {coil("a", 0.006), coil("b", 0.001), coil("c", 0.02, true, false)};
  table.with.coils = 3;
  const auto warnings = coil_warnings(table, false);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "coil-out-of-shape");
  EXPECT_EQ(warnings[0].place, "c and a");
  EXPECT_EQ(warnings[0].marks.size(), 2u);
  EXPECT_NEAR(warnings[0].figure->value, 2, 1e-9);
  EXPECT_NE(warnings[0].text.find("2 of 3 coils"), std::string::npos);
  EXPECT_NE(warnings[0].text.find("the worst, c, by 0.80 mm (2.0 %); 1 of them"), std::string::npos);
}

TEST(CoilWarnings, SayTheSpacingOfTheTable) {
  CoilTable table;
  table.with.pairs = 4, table.with.spacing_rms_mm = 2.34, table.with.worst_spacing_mm = 5;
  const auto warnings = coil_warnings(table, false);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "coils-spacing");
  EXPECT_EQ(warnings[0].figure->value, table.with.spacing_rms_mm);
  EXPECT_TRUE(coil_warnings(table, true).empty());
  table.with.spacing_rms_mm = 1.9;
  EXPECT_TRUE(coil_warnings(table, false).empty());
}

}  // namespace
}  // namespace vacuform::shape_distance_test
