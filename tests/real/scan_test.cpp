// Every real scan makes a watertight mold, or is refused for a reason that helps.
#include <gtest/gtest.h>

#include "tests/real/real_scans.hpp"
#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform::scan_test {
namespace {

struct Expected {
  const char* file;
  Unit unit;
  UpAxis up;
  Eigen::Vector3d size;  // upright, mm
  double least, most;    // height of the mold after the automatic trim
  int capped;
};
void PrintTo(const Expected& e, std::ostream* out) { *out << e.file; }

class RealScan : public testing::TestWithParam<Expected> {};

TEST_P(RealScan, MakesAMold) {
  const auto& expected = GetParam();
  VACUFORM_READ_REAL_SCAN(file, expected.file);
  const auto mold = make_mold(file, expected.file, {}, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(is_watertight(mold->mesh));
  EXPECT_GT(signed_volume(mold->mesh), 100'000);
  EXPECT_EQ(mold->findings.unit, expected.unit);
  EXPECT_EQ(mold->findings.up, expected.up) << name(mold->findings.up);
  EXPECT_NEAR((mold->findings.size_mm - expected.size).norm(), 0, 0.2) << mold->findings.size_mm.transpose();
  EXPECT_GE(mold->top.z(), expected.least);
  EXPECT_LE(mold->top.z(), expected.most);
  EXPECT_EQ(mold->findings.holes_capped, expected.capped);
  EXPECT_EQ(mold->findings.components, 1);
  EXPECT_FALSE(mold->findings.rebuilt);
  for (const auto& undercut : mold->undercuts)
    EXPECT_LT(undercut.area_mm2, 25);  // only what the trim passes over
  EXPECT_TRUE(check_fit(*mold, {}, {}));
}

INSTANTIATE_TEST_SUITE_P(
    All, RealScan,
    testing::Values(
        Expected{"neonate-40w.stl", Unit::mm, UpAxis::plus_z, {89.46, 126.20, 103.36}, 50, 57, 0},
        Expected{"adult-scalp-ascii.ply", Unit::mm, UpAxis::plus_z, {170.8, 207.3, 186.9}, 115, 125, 0},
        Expected{
            "adult-fsaverage-metres.obj", Unit::m, UpAxis::plus_z, {169.07, 220.81, 263.37}, 102, 113, 0},
        Expected{"child-headform-metres.stl", Unit::m, UpAxis::plus_y, {107.95, 148.45, 151.87}, 76, 83, 0},
        Expected{"face-mask-open-cm.obj", Unit::cm, UpAxis::plus_z, {154.86, 176.65, 100.22}, 100, 101, 1},
        Expected{"figurine-goathead.obj", Unit::cm, UpAxis::minus_x, {115.58, 158.26, 120.85}, 50, 58, 0}));

TEST(RealScans, TheBustAsksForItsUnitAndIsCutAtItsShoulders) {
  VACUFORM_READ_REAL_SCAN(file, "bust-demosthenes.obj");
  const auto asked = make_mold(file, "bust-demosthenes.obj", {}, Context());
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().code, Code::ambiguous_units);
  EXPECT_NE(asked.error().text().find("in (68 mm)"), std::string::npos) << asked.error().text();
  EXPECT_EQ(asked.error().text().find("scan.size_mm="), std::string::npos) << asked.error().text();
  EXPECT_EQ(asked.error().proposals.size(), 1u) << asked.error().text();

  ScanSettings settings;
  settings.size_mm = 250;
  settings.trim_mm = 130;
  const auto mold = make_mold(file, "bust-demosthenes.obj", settings, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(mold->findings.size_given);
  EXPECT_EQ(mold->findings.up, UpAxis::plus_y);
  EXPECT_NEAR(mold->findings.size_mm.z(), 250, 1e-9);
  EXPECT_NEAR(mold->top.z(), 120, 0.1);
  EXPECT_TRUE(is_watertight(mold->mesh));
  EXPECT_FALSE(mold->undercuts.empty());
  EXPECT_TRUE(check_fit(*mold, {}, {}));
}

TEST(RealScans, TheCorruptHeadIsRefusedWithWhatDestroyedIt) {
  VACUFORM_READ_REAL_SCAN(file, "corrupt-head.glb");
  const auto mold = make_mold(file, "corrupt-head.glb", {}, Context());
  ASSERT_FALSE(mold);
  EXPECT_EQ(mold.error().code, Code::corrupt_file);
  EXPECT_NE(mold.error().what.find("U+FFFD); it was destroyed by a text-mode copy"), std::string::npos)
      << mold.error().text();
}

TEST(RealScans, TheNeonateIsTheSameTwiceAndHoldsItsPlace) {
  VACUFORM_READ_REAL_SCAN(file, "neonate-40w.stl");
  const auto once = make_mold(file, "a.stl", {}, Context()), twice = make_mold(file, "b.stl", {}, Context());
  ASSERT_TRUE(once && twice);
  EXPECT_EQ(stl_bytes(once->mesh), stl_bytes(twice->mesh));
  EXPECT_NEAR(bounds(once->mesh).size().x(), 89.46, 0.1);
  EXPECT_NEAR(bounds(once->mesh).size().y(), 124.6, 0.1);
}

class RealScanMoves : public testing::TestWithParam<const char*> {};

// Trim and place of a scan that is turned, mirrored, doubled or shifted before it is exported.
TEST_P(RealScanMoves, MoveTheMold) {
  VACUFORM_READ_REAL_SCAN(file, GetParam());
  auto scan = read_scan(file, GetParam(), ScanProgress(Context()));
  ASSERT_TRUE(scan);
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  const auto made = [&](const Eigen::Affine3d& by) {
    auto mesh = shapes::moved(scan->mesh, by);
    if (by.linear().determinant() < 0) mesh = shapes::turned_over(std::move(mesh));
    return make_mold(stl_bytes(mesh), "scan.stl", settings, Context());
  };
  const auto mold = made(Eigen::Affine3d::Identity());
  ASSERT_TRUE(mold) << mold.error().text();
  const auto expect = [&](const Eigen::Affine3d& by, const char* how) {
    const auto other = made(by);
    ASSERT_TRUE(other) << how << ": " << other.error().text();
    const double scale = std::cbrt(std::abs(by.linear().determinant()));
    EXPECT_NEAR(other->findings.trim_mm, scale * mold->findings.trim_mm, 0.05) << how;
    EXPECT_LT((by.linear() * mold->top - other->top).norm(), 0.05) << how;
    EXPECT_EQ(other->undercuts.size(), mold->undercuts.size()) << how;
  };
  for (const int yaw : {30, 45, 90, 123})
    expect(Eigen::Affine3d(Eigen::AngleAxisd(yaw * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())),
           "turned");
  expect(Eigen::Affine3d(Eigen::Scaling(-1.0, 1.0, 1.0)), "mirrored");
  expect(Eigen::Affine3d(Eigen::Scaling(2.0)), "doubled");
  expect(Eigen::Affine3d(Eigen::Translation3d(57, -33, 21)), "shifted");
}

INSTANTIATE_TEST_SUITE_P(All, RealScanMoves, testing::Values("neonate-40w.stl", "adult-scalp-ascii.ply"));

TEST(RealScans, AClearanceGrowsTheNeonateOnAllSides) {
  ScanSettings settings;
  settings.trim_mm = 55;
  VACUFORM_READ_REAL_SCAN(file, "neonate-40w.stl");
  const auto bare = make_mold(file, "a.stl", settings, Context());
  settings.clearance_mm = 4;
  const auto padded = make_mold(file, "a.stl", settings, Context());
  ASSERT_TRUE(bare && padded);
  EXPECT_TRUE(is_watertight(padded->mesh));
  EXPECT_NEAR(padded->top.z() - bare->top.z(), 4, 0.1);
  EXPECT_NEAR(bounds(padded->mesh).size().y() - bounds(bare->mesh).size().y(), 8, 0.2);
}

}  // namespace
}  // namespace vacuform::scan_test
