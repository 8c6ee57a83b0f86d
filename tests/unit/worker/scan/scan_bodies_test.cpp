// Several large bodies in one file: two heads are asked about, a head with its stand is not two heads.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/worker/scan/scan_shapes.hpp"

namespace vacuform::scan_bodies_test {
namespace {

using namespace shapes;

constexpr double pi = std::numbers::pi;
const Context quiet;

// A head of that height in mm with a nose towards +y and a flat neck; its left is not like its right.
TriangleMesh head(double height) {
  TriangleMesh mesh = sphere(1, 40);
  for (auto& p : mesh.vertices) {
    const double nose = std::exp(-20 * (p - Eigen::Vector3d(0, 0.98, -0.2)).squaredNorm());
    const double ear = std::exp(-30 * (p - Eigen::Vector3d(-1, 0, -0.1)).squaredNorm());
    p = Eigen::Vector3d(0.36 * p.x(), 0.45 * p.y(), 0.5 * p.z()) * (1 + 0.15 * nose + 0.1 * ear);
    p.z() = std::max(p.z(), -0.44) + 0.44;
    p *= height / 0.94;
  }
  return mesh;
}

Eigen::Affine3d placed(double x, double y, double z, double yaw_deg, double tilt_deg = 0) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw_deg * pi / 180, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(tilt_deg * pi / 180, Eigen::Vector3d(0.6, 0.8, 0));
}

Result<Mold> mold_of(const TriangleMesh& mesh, BodyChoice body = BodyChoice::automatic) {
  ScanSettings settings;
  settings.units = Unit::mm;
  settings.up = UpAxis::plus_z;
  settings.body = body;
  return make_mold(stl(mesh), "scan.stl", settings, quiet);
}

const Warning* several_bodies(const Mold& mold) {
  for (const Warning& warning : mold.warnings)
    if (warning.code == "several-bodies") return &warning;
  return nullptr;
}

TEST(Bodies, TwoHeadsAreNamedAndEachProposalTakesOne) {
  // Mother and child, on a diagonal, neither at the origin.
  const auto adult = moved(head(215), placed(40, -70, 13, 33)),
             child = moved(head(110), placed(190, 60, 5, -71));
  for (const auto& both : {joined(adult, child), joined(child, adult)}) {
    const auto refused = mold_of(both);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::unusable_scan);
    EXPECT_EQ(refused.error().what, "the scan contains 2 separate bodies that can be heads");
    EXPECT_EQ(refused.error().where, "scan.body");
    ASSERT_EQ(refused.error().proposals.size(), 2u);
    EXPECT_EQ(options_of(refused.error().proposals[0]), "--set scan.body=first");
    EXPECT_EQ(options_of(refused.error().proposals[1]), "--set scan.body=second");
    // Counted along x, on which their centres are farthest apart.
    const auto first = mold_of(both, BodyChoice::first), second = mold_of(both, BodyChoice::second);
    ASSERT_TRUE(first) << first.error().text();
    ASSERT_TRUE(second) << second.error().text();
    EXPECT_NEAR(first->findings.size_mm.z(), 215, 0.01);
    EXPECT_NEAR(second->findings.size_mm.z(), 110, 0.01);
    EXPECT_EQ(first->findings.components_dropped, 1);
    EXPECT_FALSE(several_bodies(*first));
    const auto all = mold_of(both, BodyChoice::all);
    ASSERT_TRUE(all) << all.error().text();
    EXPECT_EQ(all->findings.components_dropped, 0);
  }
}

TEST(Bodies, HeadsOpenBelowAndTiltedAreCounted) {
  const auto open = without(head(200), [](const auto& p) { return p.z() < 2; });
  const auto both = joined(moved(open, placed(10, 20, 0, 5, 12)), moved(open, placed(40, 260, 30, 140, -25)));
  const auto refused = mold_of(both);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().proposals.size(), 2u);
}

TEST(Bodies, SixHeadsOnAPlateAreSix) {
  TriangleMesh plate;
  for (int i = 0; i < 6; ++i)
    plate =
        joined(std::move(plate), moved(head(120 + 3 * i), placed(150 * (i % 3), 170 * (i / 3), 0, 50 * i)));
  const auto refused = mold_of(plate);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().what, "the scan contains 6 separate bodies that can be heads");
  ASSERT_EQ(refused.error().proposals.size(), 6u);
  const auto sixth = mold_of(plate, BodyChoice::sixth);
  ASSERT_TRUE(sixth) << sixth.error().text();
  EXPECT_EQ(sixth->findings.components_dropped, 5);
  const auto seventh = mold_of(plate, BodyChoice::seventh);
  ASSERT_FALSE(seventh);
  EXPECT_EQ(seventh.error().what, "the scan has no seventh body: it contains 6");
}

// Debris beside the other head goes with it.
TEST(Bodies, WhatLiesAtTheOtherHeadIsDropped) {
  const auto adult = moved(head(215), placed(0, 0, 0, 33)), child = moved(head(110), placed(260, 40, 0, -71));
  const auto cap = moved(box({-30, -25, 0}, {28, 24, 6}), placed(262, 41, 113, 20));  // above the child
  const auto mold = mold_of(joined(joined(adult, child), cap), BodyChoice::first);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.components_dropped, 2);
  EXPECT_NEAR(mold->findings.size_mm.z(), 215, 0.01);
}

TEST(Bodies, AStandOrABallIsNoSecondHead) {
  const auto subject = moved(head(215), placed(12, -7, 90, 21));
  const std::pair<const char*, TriangleMesh> parts[] = {
      {"block", moved(box({-60, -70, -85}, {65, 75, -2}), placed(0, 0, 88, 10))},
      {"pedestal", shifted(lathe({{0, -84}, {55, -84}, {55, -1}, {0, -1}}, 96), 5, 3, 88)},
      {"tall pedestal", shifted(lathe({{0, -170}, {45, -170}, {45, -1}, {0, -1}}, 64), 5, 3, 88)},
      {"ball", shifted(sphere(60), 200, 30, 90)}};
  for (const auto& [name, part] : parts) {
    const auto mold = mold_of(joined(subject, part));
    ASSERT_TRUE(mold) << name << ": " << mold.error().text();
    const Warning* warning = several_bodies(*mold);
    ASSERT_TRUE(warning) << name;
    EXPECT_EQ(warning->proposals.size(), 2u) << name;
    EXPECT_EQ(mold->findings.components_dropped, 0) << name;
    // One of the two proposals takes the head alone.
    const auto first = mold_of(joined(subject, part), BodyChoice::first),
               second = mold_of(joined(subject, part), BodyChoice::second);
    ASSERT_TRUE(first && second) << name;
    const double one = first->findings.size_mm.z(), other = second->findings.size_mm.z();
    EXPECT_NEAR(std::min(std::abs(one - 215), std::abs(other - 215)), 0, 0.01) << name;
  }
}

TEST(Bodies, OneHeadIsNotAskedAbout) {
  const auto subject = moved(head(215), placed(12, -7, 0, 21, 8));
  EXPECT_FALSE(several_bodies(*mold_of(subject)));
  EXPECT_FALSE(several_bodies(*mold_of(subject, BodyChoice::first)));
  // A small floating part, an inner skin and a body that crosses the head are no further bodies.
  const auto inner = moved(turned_over(scaled(head(215), 0.8)), placed(12, -7, 20, 21, 8));
  const auto crossing = moved(head(150), placed(60, -7, 10, 80));
  for (const auto& part : {shifted(sphere(25), 200, 30, 90), inner, crossing}) {
    const auto mold = mold_of(joined(subject, part));
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_FALSE(several_bodies(*mold));
  }
}

// Two halves of a part that was cut flat for a small printer are no two heads.
TEST(Bodies, TwoHalvesOfAHeadAreNoTwoHeads) {
  auto left = head(215), right = left;
  for (auto& p : left.vertices) p.x() = std::min(p.x(), 0.0);
  for (auto& p : right.vertices) p.x() = std::max(p.x(), 0.0) + 40;
  const auto mold = mold_of(joined(left, right));
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(several_bodies(*mold));
}

}  // namespace
}  // namespace vacuform::scan_bodies_test
