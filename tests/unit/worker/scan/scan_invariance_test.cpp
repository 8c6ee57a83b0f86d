// A mold moves with its scan: turned, mirrored, doubled or shifted, the trim and the place on the platform stay the same.
#include <gtest/gtest.h>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/placing.hpp"

namespace vacuform::scan_invariance_test {
namespace {

using namespace shapes;
using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double radian = std::numbers::pi / 180;

// A head: longer than wide, wider behind, with a nose, ears at different heights and a neck; no two sides alike.
TriangleMesh head() {
  auto mesh = sphere(1, 60);
  const auto bump = [](const Vector3d& p, const Vector3d& at, double width) {
    return std::exp(-(p - at.normalized()).squaredNorm() / (width * width));
  };
  for (auto& p : mesh.vertices) {
    const Vector3d d = p;
    double r = 1 + 0.02 * d.x() - 0.12 * d.y() - 0.06 * std::abs(d.x()) * d.y();
    r += 0.16 * bump(d, {0.05, 1, -0.25}, 0.15);
    r += 0.12 * bump(d, {1, 0.1, -0.15}, 0.12) + 0.1 * bump(d, {-1, 0.05, -0.22}, 0.12);
    r -= 0.25 * bump(d, {0, 0.3, -1}, 0.7);
    p = r * d.cwiseProduct(Vector3d(72, 95, 88));
  }
  return mesh;
}

Result<Mold> mold_of(const TriangleMesh& mesh, double yaw_deg = 0) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.yaw_deg = yaw_deg;
  return make_mold(stl(mesh), "scan.stl", settings, Context());
}

// The farthest that a vertex of one is from every vertex of the other.
double distance(const TriangleMesh& one, const TriangleMesh& other) {
  double most = 0;
  for (const auto& p : one.vertices) {
    double least = HUGE_VAL;
    for (const auto& q : other.vertices) least = std::min(least, (p - q).squaredNorm());
    most = std::max(most, least);
  }
  return std::sqrt(most);
}

void expect_moved(const Mold& from, const Result<Mold>& to, const Eigen::Affine3d& by,
                  const std::string& how) {
  ASSERT_TRUE(to) << how << ": " << to.error().text();
  const double scale = std::cbrt(std::abs(by.linear().determinant()));
  EXPECT_NEAR(to->findings.trim_mm, scale * from.findings.trim_mm, 0.05) << how;
  EXPECT_LT(distance(moved(from.mesh, by), to->mesh), 0.05) << how;
  EXPECT_LT((by * from.top - to->top).norm(), 0.05) << how;
  EXPECT_EQ(from.undercuts.size(), to->undercuts.size()) << how;
}

TEST(Invariance, TheMoldTurnsWithTheScan) {
  const auto mold = mold_of(head());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(mold->findings.trim_chosen);
  EXPECT_GT(mold->findings.trim_mm, 30);
  for (const double yaw : {7.3, 30.0, 45.0, 90.0, 133.3, 180.0, 270.0}) {
    const Eigen::Affine3d turn(AngleAxisd(yaw * radian, Vector3d::UnitZ()));
    expect_moved(*mold, mold_of(moved(head(), turn)), turn, "the file turned by " + std::to_string(yaw));
  }
  for (const double yaw : {30.0, 45.0, -90.0}) {
    const Eigen::Affine3d turn(AngleAxisd(yaw * radian, Vector3d::UnitZ()));
    expect_moved(*mold, mold_of(head(), yaw), turn, "scan.yaw_deg = " + std::to_string(yaw));
  }
}

TEST(Invariance, TheMoldIsMirroredDoubledAndShiftedWithTheScan) {
  const auto mold = mold_of(head());
  ASSERT_TRUE(mold) << mold.error().text();
  for (const Vector3d& mirror : {Vector3d(-1, 1, 1), Vector3d(1, -1, 1)}) {
    const Eigen::Affine3d by{Eigen::Scaling(mirror)};
    expect_moved(*mold, mold_of(turned_over(moved(head(), by))), by, "mirrored");
  }
  const Eigen::Affine3d twice{Eigen::Scaling(2.0)};
  expect_moved(*mold, mold_of(moved(head(), twice)), twice, "doubled");
  expect_moved(*mold, mold_of(shifted(head(), 31.7, -412.3, 97.1)), Eigen::Affine3d::Identity(), "shifted");
}

TEST(Invariance, AGivenSizeAndAGuessedUnitDoNotDependOnTheTurn) {
  // Wider and deeper than high, so that the longest side lies flat.
  auto flat = without(head(), [](const Vector3d& p) { return p.z() < 40; });
  ScanSettings sized;
  sized.size_mm = 180;
  sized.up = UpAxis::plus_z;
  const auto mold = make_mold(stl(flat), "scan.stl", sized, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  for (const double yaw : {0.0, 13.0, 45.0, 60.0, 90.0}) {
    const auto turned = moved(flat, Eigen::Affine3d(AngleAxisd(yaw * radian, Vector3d::UnitZ())));
    const auto other = make_mold(stl(turned), "scan.stl", sized, Context());
    ASSERT_TRUE(other) << other.error().text();
    EXPECT_NEAR(other->top.z(), mold->top.z(), 0.02) << yaw;
    EXPECT_NEAR(enclosing_circle(other->mesh).radius, enclosing_circle(mold->mesh).radius, 0.05) << yaw;
    const auto guessed = make_mold(stl(turned), "scan.stl", {}, Context());
    ASSERT_TRUE(guessed) << guessed.error().text();
    EXPECT_EQ(guessed->findings.unit, Unit::mm) << yaw;
    EXPECT_EQ(guessed->findings.up, UpAxis::plus_z) << yaw;
  }
}

TEST(LongestSide, IsThatOfTheSmallestBoxSeenFromAbove) {
  for (const double yaw : {0.0, 1.0, 30.0, 45.0, 77.7, 90.0, 180.0}) {
    const Eigen::Affine3d turn(AngleAxisd(yaw * radian, Vector3d::UnitZ()));
    EXPECT_NEAR(longest_side(moved(box({0, 0, 0}, {30, 20, 10}), turn)), 30, 1e-9) << yaw;
    EXPECT_NEAR(longest_side(moved(box({5, 5, 0}, {25, 25, 10}), turn)), 20, 1e-9) << yaw;
    EXPECT_NEAR(longest_side(moved(box({0, 0, 0}, {3, 2, 10}), turn)), 10, 1e-9) << yaw;
    EXPECT_NEAR(longest_side(moved(head(), turn)), longest_side(head()), 0.01) << yaw;
  }
  EXPECT_EQ(longest_side({{{0, 0, 0}, {4, 0, 0}, {2, 0, 1}}, {{0, 1, 2}}}), 4);
  EXPECT_EQ(longest_side({}), 0);
}

TEST(Invariance, ANewSkinTurnsWithTheScan) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.clearance_mm = 4;
  const auto mold = make_mold(stl(head()), "scan.stl", settings, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  settings.yaw_deg = 45;
  const auto turned = make_mold(stl(head()), "scan.stl", settings, Context());
  ASSERT_TRUE(turned)
      << turned.error().text();  // with other triangles: rounding changes where the skin's vertices lie
  EXPECT_NEAR(turned->findings.trim_mm, mold->findings.trim_mm, 0.05);
  EXPECT_NEAR(turned->top.z(), mold->top.z(), 0.05);
  EXPECT_NEAR(signed_volume(turned->mesh), signed_volume(mold->mesh), 1e-3 * signed_volume(mold->mesh));
  EXPECT_NEAR(enclosing_circle(turned->mesh).radius, enclosing_circle(mold->mesh).radius, 0.05);
}

TEST(EnclosingCircle, HoldsAllVerticesAndIsTheSmallest) {
  const auto circle = [](std::vector<Vector3d> points) { return enclosing_circle({std::move(points), {}}); };
  const auto pair = circle({{0, 0, 0}, {6, 8, 50}, {3, 4, 0}, {4, 4, 7}});
  EXPECT_NEAR((pair.centre - Eigen::Vector2d(3, 4)).norm(), 0, 1e-12);
  EXPECT_NEAR(pair.radius, 5, 1e-12);
  const auto three = circle({{1, 0, 0}, {-0.6, 0.8, 0}, {-0.6, -0.8, 0}, {0, 0, 0}, {0.9, 0.1, 0}});
  EXPECT_NEAR(three.centre.norm(), 0, 1e-12);
  EXPECT_NEAR(three.radius, 1, 1e-12);
  EXPECT_EQ(circle({{5, 5, 5}, {5, 5, 9}}).radius, 0);
  EXPECT_EQ(circle({}).radius, 0);
  EXPECT_NEAR(circle({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {7, 0, 0}}).radius, 3.5, 1e-12);  // in a line
  const auto egg = head();
  const Circle around = enclosing_circle(egg);
  double most = 0;
  for (const auto& p : egg.vertices) most = std::max(most, (p.head<2>() - around.centre).norm());
  EXPECT_NEAR(most, around.radius, 1e-9);
}

TEST(PrincipalTurn, BringsTheLongAxisToXAndTheHeavyEndToItsPositiveSide) {
  const auto shape = joined(box({-10, -50, 0}, {10, 50, 20}), box({-30, 40, 0}, {30, 60, 20}));
  for (const double yaw : {0.0, 20.0, 110.0, 200.0}) {
    const auto turned = moved(shape, Eigen::Affine3d(AngleAxisd(yaw * radian, Vector3d::UnitZ())));
    const Vector3d along =
        principal_turn(turned) * AngleAxisd(yaw * radian, Vector3d::UnitZ()) * Vector3d::UnitY();
    EXPECT_NEAR(std::abs(along.x()), 1, 1e-9) << yaw;
    EXPECT_LT(along.x(), 0) << yaw;  // the long thin end reaches farther out
  }
  EXPECT_TRUE(principal_turn({}).isIdentity());
}

TEST(Crumbs, AreDroppedBeforeTheMoldIsCentred) {
  // A block, and an ear whose tip the trim leaves standing 0.36 mm high.
  const auto block = box({-40, -40, 0}, {40, 40, 100});
  const auto eared = joined(block, box({60, -5, 0}, {72, 5, 50.36}));
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.trim_mm = 50;
  const auto mold = make_mold(stl(eared), "scan.stl", settings, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.crumbs_dropped, 1);
  EXPECT_NEAR(signed_volume(mold->mesh), 80 * 80 * 50, 1);
  EXPECT_NEAR(bounds(mold->mesh).centre().x(), 0, 1e-4);

  settings.trim_mm = 30;  // a piece of 2,443 mm3 is no crumb
  const auto both = make_mold(stl(eared), "scan.stl", settings, Context());
  ASSERT_TRUE(both) << both.error().text();
  EXPECT_EQ(both->findings.crumbs_dropped, 0);
  EXPECT_NEAR(bounds(both->mesh).size().x(), 112, 1e-3);
}

}  // namespace
}  // namespace vacuform::scan_invariance_test
