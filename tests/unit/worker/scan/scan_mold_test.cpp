// Closing, trimming, undercuts, clearance, rebuilding, placing, fitting.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/cutting.hpp"
#include "worker/scan/placing.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/welding.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform::scan_mold_test {
namespace {

using namespace shapes;

constexpr double pi = std::numbers::pi;

Result<Mold> mold_of(const TriangleMesh& mesh, const ScanSettings& settings) {
  return make_mold(stl(mesh), "scan.stl", settings, Context());
}

ScanSettings upright(std::optional<double> trim = {}) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.trim_mm = trim;
  return settings;
}
bool warns(const Mold& mold, const std::string& code) {
  for (const auto& w : mold.warnings)
    if (w.code == code) return true;
  return false;
}
void expect_sound(const Mold& mold) {
  EXPECT_TRUE(is_watertight(mold.mesh));
  EXPECT_GT(signed_volume(mold.mesh), 0);
  const Box box = bounds(mold.mesh);
  EXPECT_GE(box.low.z(), 0);
  EXPECT_NEAR(box.low.z(), 0, 1e-3);
  EXPECT_NEAR(enclosing_circle(mold.mesh).centre.norm(), 0, 1e-4);
  EXPECT_EQ(mold.top.z(), box.high.z());
}
// The sphere's volume above a plane h below its top.
double cap_volume(double radius, double h) { return pi * h * h * (radius - h / 3); }

TEST(Trim, LeavesASeventiethOfTheRadiusOfASphere) {
  for (const double radius : {50.0, 85.0}) {
    const auto mold = mold_of(sphere(radius, 96), upright());
    ASSERT_TRUE(mold) << mold.error().text();
    expect_sound(*mold);
    EXPECT_TRUE(mold->findings.trim_chosen);
    // At d below the equator the undercut is r - sqrt(r^2 - d^2); half a cell of the grid, r / 500, more or less.
    const auto cut = [&](double depth) { return radius - std::sqrt(2 * radius * depth - depth * depth); };
    EXPECT_GT(mold->findings.trim_mm, cut(radius / 70 + radius / 500)) << cut(radius / 70);
    EXPECT_LT(mold->findings.trim_mm, cut(radius / 70 - radius / 500)) << cut(radius / 70);
    EXPECT_TRUE(mold->undercuts.empty());
    EXPECT_NEAR(signed_volume(mold->mesh), cap_volume(radius, 2 * radius - mold->findings.trim_mm),
                0.003 * cap_volume(radius, 2 * radius));
  }
}

TEST(Trim, GivenIsTheHeightAboveTheLowestPoint) {
  const auto mold = mold_of(shifted(sphere(80, 96), 500, -300, 1000), upright(100.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_EQ(mold->findings.trim_mm, 100);
  EXPECT_FALSE(mold->findings.trim_chosen);
  EXPECT_NEAR(mold->top.z(), 60, 1e-3);
  EXPECT_NEAR(signed_volume(mold->mesh), cap_volume(80, 60), 0.002 * cap_volume(80, 60));
  EXPECT_NEAR(bounds(mold->mesh).size().x(), 2 * std::sqrt(80 * 80 - 20 * 20), 0.1);
}

TEST(Trim, AboveTheScanIsRefused) {
  const auto mold = mold_of(sphere(50), upright(150.0));
  ASSERT_FALSE(mold);
  EXPECT_EQ(mold.error().code, Code::unusable_scan);
  EXPECT_EQ(mold.error().where, "scan.trim_mm");
  EXPECT_NE(mold.error().what.find("the scan is 100.0 mm high and trimming it at 150.0 mm leaves nothing"),
            std::string::npos);
  EXPECT_NE(mold.error().fix.find("--set scan.trim_mm=50"), std::string::npos) << mold.error().fix;
  EXPECT_TRUE(mold_of(sphere(50), upright(50.0)));
}

TEST(Trim, ThroughVerticesAndFlatFacesStaysWatertight) {
  // The planes of a lathe's rings, of a box's faces, and of a step whose tread lies in the plane.
  const auto steps = lathe({{0, 0}, {60, 0}, {60, 30}, {40, 30}, {40, 60}, {0, 60}}, 48);
  for (const double trim : {0.0, 10.0, 29.9995, 30.0, 30.0005, 45.0}) {
    const auto mold = mold_of(steps, upright(trim));
    ASSERT_TRUE(mold) << trim << ": " << mold.error().text();
    expect_sound(*mold);
    const double area = 48 / 2.0 * std::sin(2 * pi / 48);  // of a 48-gon of radius 1
    const double exact = area * (trim < 30 ? 3600 * (30 - trim) + 1600 * 30 : 1600 * (60 - trim));
    EXPECT_NEAR(signed_volume(mold->mesh), exact, 0.0005 * exact + 20) << trim;
  }
}

TEST(Undercuts, GiveDepthPlaceAndAreaOnAMushroom) {
  const auto mold = mold_of(mushroom(40), upright(10.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  ASSERT_EQ(mold->undercuts.size(), 1u);
  const auto& undercut = mold->undercuts.front();
  EXPECT_NEAR(undercut.depth_mm, 25, 0.5);
  EXPECT_NEAR(undercut.area_mm2, pi * (40 * 40 - 15 * 15), 0.01 * pi * 1375);
  EXPECT_NEAR(undercut.place.head<2>().norm(), 15, 0.8);
  EXPECT_NEAR(undercut.place.z(), 0, 1e-9);
  ASSERT_TRUE(warns(*mold, "undercut"));
  EXPECT_NE(mold->warnings.back().text.find("it reaches 2"), std::string::npos) << mold->warnings.back().text;
}

TEST(Undercuts, AreTrimmedFromAMushroom) {
  const auto mold = mold_of(mushroom(40), upright());
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_NEAR(mold->findings.trim_mm, 40, 0.4);
  EXPECT_TRUE(mold->undercuts.empty());
}

TEST(Undercuts, ThatLeaveACoinAreRefusedWithTheirHeight) {
  const auto mold = mold_of(mushroom(2), upright());
  ASSERT_FALSE(mold);
  EXPECT_EQ(mold.error().code, Code::unusable_scan);
  EXPECT_EQ(mold.error().text().find("undercuts begin 39."), 0u) << mold.error().text();
  EXPECT_NE(mold.error().fix.find("--set scan.up=-z"), std::string::npos) << mold.error().text();
  EXPECT_NE(mold.error().fix.find("--set scan.trim_mm=21"), std::string::npos) << mold.error().text();
  // Both proposals make a mold.
  auto turned = upright();
  turned.up = UpAxis::minus_z;
  EXPECT_TRUE(mold_of(mushroom(2), turned));
  EXPECT_TRUE(mold_of(mushroom(2), upright(21.0)));
}

TEST(Trim, ThatDiscardsMostOfTheScanIsWarnedOf) {
  for (const double scale : {1.0, 4.0}) {  // by share, not by height
    const auto mold = mold_of(scaled(mushroom(12), scale), upright());
    ASSERT_TRUE(mold) << mold.error().text();
    ASSERT_TRUE(warns(*mold, "trim-discards"));
    const Warning& warning = mold->warnings.front();
    EXPECT_NE(warning.text.find("keeps 23 % of its height"), std::string::npos) << warning.text;
    ASSERT_TRUE(warning.figure);
    EXPECT_NEAR(warning.figure->value, 77, 0.5);
    EXPECT_EQ(warning.figure->unit, "%");
    EXPECT_NEAR(warning.figure->limit.value_or(0), 66.7, 0.1);
    ASSERT_EQ(warning.marks.size(), 1u);
    EXPECT_LE(std::hypot(warning.marks[0].place_mm[0], warning.marks[0].place_mm[1]), 40 * scale);
    ASSERT_EQ(warning.proposals.size(), 2u);
    EXPECT_EQ(options_of(warning.proposals[0]), "--set scan.up=-z");  // stands on its cap
    EXPECT_NE(warning.what_to_do().find("--set scan.up=-z"), std::string::npos) << warning.what_to_do();
  }
  const auto kept = mold_of(sphere(60), upright());
  ASSERT_TRUE(kept);
  EXPECT_FALSE(warns(*kept, "trim-discards"));
  EXPECT_FALSE(warns(*mold_of(mushroom(12), upright(40.0)), "trim-discards"));  // as was asked
}

TEST(Undercuts, AreClusteredDeepestFirst) {
  // A post with two shelves of 12 and 8 mm that stand out on opposite sides, at different heights.
  auto mesh = box({-20, -20, 0}, {20, 20, 100});
  mesh = joined(mesh, joined(box({19, -20, 50}, {32, 20, 60}), box({-28, -10, 30}, {-19, 10, 40})));
  const auto space = CoveredSpace::measure(mesh, 0, 0.5, ScanProgress(Context()));
  ASSERT_TRUE(space);
  const auto undercuts = space->undercuts(0);
  ASSERT_EQ(undercuts.size(), 2u);
  EXPECT_NEAR(undercuts[0].depth_mm, 12, 0.5);
  EXPECT_NEAR(undercuts[0].area_mm2, 480, 25);
  EXPECT_GT(undercuts[0].place.x(), 19);
  EXPECT_NEAR(undercuts[1].depth_mm, 8, 0.5);
  EXPECT_LT(undercuts[1].place.x(), -19);
  EXPECT_NEAR(space->lowest_cut(1, 20), 50, 0.4);
  EXPECT_NEAR(space->lowest_cut(10, 20), 50, 0.4);
  EXPECT_EQ(space->lowest_cut(13, 20), 0);
  EXPECT_EQ(space->lowest_cut(1, 520), 0);
}

TEST(Undercuts, PitsAreNone) {
  auto pit = lathe({{0, 0}, {60, 0}, {60, 50}, {30, 50}, {10, 20}, {0, 20}}, 64);
  const auto mold = mold_of(pit, upright(0.0));
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(mold->undercuts.empty());
}

TEST(Undercuts, TheInsideOfAHollowShellIsNone) {
  // A half shell 1.5 mm thick, as it comes off a printer, standing on its rim; and the same with a window in
  // its side.
  std::vector<Eigen::Vector2d> profile{{0, 80}};
  for (int k = 23; k >= 0; --k) profile.emplace_back(80 * std::cos(pi * k / 48), 80 * std::sin(pi * k / 48));
  for (int k = 0; k < 24; ++k)
    profile.emplace_back(78.5 * std::cos(pi * k / 48), 78.5 * std::sin(pi * k / 48));
  profile.emplace_back(0, 78.5);
  const auto shell = turned_over(lathe(profile, 96));
  const auto mold = mold_of(shell, upright());
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_EQ(mold->findings.trim_mm, 0);
  EXPECT_TRUE(mold->undercuts.empty());
  ScanSettings automatic;
  const auto guessed = mold_of(fallen(shell, Eigen::Vector3d::UnitX()), automatic);
  ASSERT_TRUE(guessed) << guessed.error().text();
  EXPECT_EQ(guessed->findings.up, UpAxis::plus_x);
  EXPECT_NEAR(guessed->top.z(), 80, 0.1);
}

TEST(Closing, ASmallHoleIsFilled) {
  auto mesh = sphere(60);
  mesh.triangles.erase(mesh.triangles.begin() + 2000, mesh.triangles.begin() + 2002);
  const auto mold = mold_of(mesh, upright(0.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_EQ(mold->findings.holes_closed, 1);
  EXPECT_EQ(mold->findings.holes_capped, 0);
  EXPECT_FALSE(mold->findings.rebuilt);
  EXPECT_NEAR(signed_volume(mold->mesh), signed_volume(sphere(60)), 20);
}

TEST(Closing, AHeadCutByTheScanBoxIsClosedOnAllSides) {
  // The bottom is open, and so is one side where the head left the scanner's box.
  const auto mesh = without(sphere(80, 64), [](const auto& p) { return p.z() < -50 || p.x() > 70; });
  const auto mold = mold_of(mesh, ScanSettings{});
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_EQ(mold->findings.up, UpAxis::plus_z);
  EXPECT_EQ(mold->findings.holes_capped, 1);
  EXPECT_EQ(mold->findings.holes_closed, 1);
  EXPECT_TRUE(warns(*mold, "large-hole"));
  EXPECT_NEAR(bounds(mold->mesh).size().x(), 152, 4);
  const double exact = cap_volume(80, mold->top.z()) - cap_volume(80, 10);
  EXPECT_NEAR(signed_volume(mold->mesh), exact, 0.02 * exact);
}

TEST(Closing, AMaskGetsWallsDownToThePlatform) {
  // A shallow open bowl, turned over, with a wavy rim: a mask without a back, lying on its rim.
  auto mask = without(sphere(90, 64),
                      [](const auto& p) { return p.z() < 30 + 8 * std::sin(3 * std::atan2(p.y(), p.x())); });
  const auto mold = mold_of(mask, upright());
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_EQ(mold->findings.holes_capped, 1);
  EXPECT_FALSE(mold->findings.rebuilt);
  EXPECT_NEAR(mold->findings.trim_mm, 0, 1e-9);
  EXPECT_NEAR(bounds(mold->mesh).high.z(), mold->findings.size_mm.z(), 1e-3);
  EXPECT_GT(signed_volume(mold->mesh), cap_volume(90, 60));
}

TEST(Closing, AMaskOnItsFaceIsFilledAcross) {
  const auto bowl = without(sphere(90, 64), [](const auto& p) { return p.z() > -20; });
  const auto mold = mold_of(bowl, upright(5.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_EQ(mold->findings.holes_capped, 0);
  EXPECT_EQ(mold->findings.holes_closed, 1);
  EXPECT_GT(signed_volume(mold->mesh),
            cap_volume(90, 70) - cap_volume(90, 5));  // a ring more or less at the rim
  EXPECT_LT(signed_volume(mold->mesh), cap_volume(90, 75) - cap_volume(90, 5));
}

TEST(Closing, BoxesThatShareAnEdgeAreMadeSound) {
  auto mesh = joined(box({0, 0, 0}, {60, 60, 60}), box({60, 60, 0}, {120, 120, 60}));
  const auto mold = mold_of(mesh, upright(0.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_NEAR(signed_volume(mold->mesh), 2 * 216'000, 0.02 * 432'000);
}

// Each triangle on its own, shrunk by a twentieth, every other one turned over.
TriangleMesh loose(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const auto& t : mesh.triangles) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int v : t) middle += mesh.vertices[static_cast<std::size_t>(v)] / 3;
    const int first = static_cast<int>(soup.vertices.size());
    for (const int v : t)
      soup.vertices.push_back(middle + 0.95 * (mesh.vertices[static_cast<std::size_t>(v)] - middle));
    soup.triangles.push_back({first, first + 1, first + 2});
    if (first % 2) std::swap(soup.triangles.back()[1], soup.triangles.back()[2]);
  }
  return soup;
}

TEST(Rebuilding, ASoupOfLooseTrianglesBecomesOneSkin) {
  const auto whole = sphere(60, 40);
  const auto mold = mold_of(loose(whole), upright(0.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_TRUE(mold->findings.rebuilt);
  EXPECT_TRUE(warns(*mold, "rebuilt"));
  EXPECT_NEAR(signed_volume(mold->mesh), signed_volume(whole), 0.01 * signed_volume(whole));
  const Eigen::Vector3d centre(0, 0, 60);
  for (const auto& p : mold->mesh.vertices) ASSERT_NEAR((p - centre).norm(), 60, 0.3);
}

TEST(Rebuilding, AnOpenBustInLoosePatchesIsSolidInside) {
  const auto bust = without(sphere(70, 40), [](const auto& p) { return p.z() < -30; });
  const auto mold = mold_of(loose(bust), upright(10.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_TRUE(mold->findings.rebuilt);
  const double exact = cap_volume(70, mold->top.z());
  EXPECT_NEAR(signed_volume(mold->mesh), exact, 0.01 * exact);
}

TEST(Rebuilding, PatchesWithGapsAreWrapped) {
  TriangleMesh patches;
  for (const int x : {-1, 1})
    for (const int y : {-1, 1})
      patches = joined(
          patches,
          shifted(without(sphere(60, 40), [&](const auto& p) { return x * p.x() < 0 || y * p.y() < 0; }),
                  0.1 * x, 0.1 * y, 0));
  const auto mold = mold_of(patches, upright(0.0));
  ASSERT_TRUE(mold) << mold.error().text();
  expect_sound(*mold);
  EXPECT_TRUE(mold->findings.rebuilt);
  EXPECT_NEAR(signed_volume(mold->mesh), signed_volume(sphere(60, 40)),
              0.015 * signed_volume(sphere(60, 40)));
}

// Fifty-one plates, each with its upper and its lower side.
TEST(Undercuts, FiftyLayersAreRefused) {
  TriangleMesh pile;
  for (int i = 0; i < 51; ++i) pile = joined(pile, box({0, 0, 2.0 * i}, {60, 60, 2.0 * i + 1}));
  const auto space = CoveredSpace::measure(pile, 0, 0.5, ScanProgress(Context()));
  ASSERT_FALSE(space);
  EXPECT_EQ(space.error().code, Code::unusable_scan);
  EXPECT_NE(space.error().text().find("more than fifty above each other"), std::string::npos)
      << space.error().text();
}

// Needles that all begin in one point: each step of a wrap has to look at all of them.
TEST(Wrapping, EndsWhereItsBudgetDoes) {
  TriangleMesh needles;
  needles.vertices = {{0, 0, 0}};
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (2 * i + 1) / 2000.0, r = std::sqrt(1 - z * z), turn = 2.4 * i;
    const Eigen::Vector3d tip(60 * r * std::cos(turn), 60 * r * std::sin(turn), 60 * z);
    needles.vertices.push_back(tip);
    needles.vertices.push_back(tip + Eigen::Vector3d(0.1, 0.1, 0));
    needles.triangles.push_back({0, 2 * i + 1, 2 * i + 2});
  }
  WrapBudget budget{1'000'000};
  const auto refused = wrap(needles, 20, 0.1, ScanProgress(Context()), budget);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::unusable_scan);
  EXPECT_EQ(budget.tests, 0);

  const auto ball = sphere(60, 40);
  budget.tests = 5'000'000;
  ASSERT_TRUE(wrap(ball, 20, 0.1, ScanProgress(Context()), budget));
  const std::int64_t used = 5'000'000 - budget.tests;
  EXPECT_LT(used, 4'000'000);
  budget.tests = 5'000'000;
  ASSERT_TRUE(wrap(ball, 20, 0.1, ScanProgress(Context()), budget));
  EXPECT_EQ(5'000'000 - budget.tests, used);  // counted, not timed
}

TEST(Clearance, IsAnOffsetWithinAPercent) {
  for (const double clearance : {2.0, 5.0, 12.0}) {
    auto settings = upright(60.0);
    settings.clearance_mm = clearance;
    const auto mold = mold_of(sphere(60, 64), settings);
    ASSERT_TRUE(mold) << mold.error().text();
    expect_sound(*mold);
    double least = 1e9, most = 0;
    for (const auto& p : mold->mesh.vertices) {
      if (p.z() < 0.01) continue;  // the cap
      least = std::min(least, p.norm());
      most = std::max(most, p.norm());
    }
    EXPECT_NEAR(most, 60 + clearance, 0.05 + 0.01 * clearance);
    EXPECT_NEAR(least, 60 + clearance, 0.15 + 0.01 * clearance);
    EXPECT_NEAR(mold->top.z(), 60 + clearance, 0.1);
  }
}

TEST(Mold, IsTheSameTwiceAndItsFileIsItsMesh) {
  const auto scan = joined(sphere(90), shifted(sphere(5, 8), 200, 0, 0));
  auto settings = upright();
  settings.yaw_deg = 33;
  settings.clearance_mm = 3;
  const auto once = mold_of(scan, settings), twice = mold_of(scan, settings);
  ASSERT_TRUE(once && twice);
  const auto bytes = stl_bytes(once->mesh);
  EXPECT_EQ(bytes, stl_bytes(twice->mesh));
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 17), "Vacuform mold, mm");
  auto back = read_scan(bytes, "mold.stl", ScanProgress(Context()));
  ASSERT_TRUE(back) << back.error().text();
  weld(back->mesh, 0);
  EXPECT_TRUE(is_watertight(back->mesh));
  EXPECT_EQ(back->mesh.vertices.size(), once->mesh.vertices.size());
  EXPECT_EQ(signed_volume(back->mesh), signed_volume(once->mesh));
}

TEST(Mold, IsTurnedByRollPitchAndYaw) {
  auto settings = upright(0.0);
  settings.yaw_deg = 90;
  const auto mesh = box({0, 0, 0}, {100, 60, 40});
  auto mold = mold_of(mesh, settings);
  ASSERT_TRUE(mold);
  EXPECT_NEAR((bounds(mold->mesh).size() - Eigen::Vector3d(60, 100, 40)).norm(), 0, 1e-4);
  settings.yaw_deg = 0;
  settings.roll_deg = 90;
  mold = mold_of(mesh, settings);
  ASSERT_TRUE(mold);
  EXPECT_NEAR((bounds(mold->mesh).size() - Eigen::Vector3d(100, 40, 60)).norm(), 0, 1e-4);
}

TEST(Mold, TopIsNearestTheAxisOfSeveral) {
  const auto mold = mold_of(box({0, 0, 0}, {100, 60, 40}), upright(0.0));
  ASSERT_TRUE(mold);
  EXPECT_EQ(mold->top.z(), 40);
  const auto cone = mold_of(lathe({{0, 0}, {50, 0}, {0, 70}}, 32), upright(0.0));
  ASSERT_TRUE(cone);
  EXPECT_NEAR((cone->top - Eigen::Vector3d(0, 0, 70)).norm(), 0, 1e-4);
}

TEST(Mold, ProgressNeverGoesBackAndCancellingWorks) {
  const auto scan = stl(sphere(90, 64));
  double last = -1;
  const auto mold = make_mold(scan, "scan.stl", {}, Context([&](Stage stage, double fraction) {
                                EXPECT_EQ(stage, Stage::scan);
                                EXPECT_GE(fraction, last);
                                EXPECT_LE(fraction, 1);
                                last = fraction;
                              }));
  ASSERT_TRUE(mold);
  EXPECT_EQ(last, 1);
  auto padded = upright();
  padded.clearance_mm = 3;
  for (const int reports : {1, 5, 20}) {
    int seen = 0;
    Context* running = nullptr;
    Context context([&](Stage, double) {
      if (++seen == reports) running->cancel();
    });
    running = &context;
    const auto cancelled = make_mold(scan, "scan.stl", padded, context);
    ASSERT_FALSE(cancelled) << reports;
    EXPECT_EQ(cancelled.error().code, Code::cancelled);
    EXPECT_LE(seen, reports + 1);
  }
}

Mold block(double x, double y, double z) {
  Mold mold;
  mold.mesh = box({-x / 2, -y / 2, 0}, {x / 2, y / 2, z});
  mold.top = {0, 0, z};
  return mold;
}

TEST(Fit, SaysWhatIsTooLargeByHowMuch) {
  const SheetSettings sheet;  // 300 x 300 x 1
  MachineSettings machine;    // 280 x 280
  EXPECT_TRUE(check_fit(block(266, 266, 50), sheet, machine));
  EXPECT_FALSE(check_fit(block(266, 266, 100), sheet, machine));  // a wall of 100 mm wants a gap of 9.1 mm
  EXPECT_TRUE(check_fit(block(260, 260, 100), sheet, machine));
  const auto wide = check_fit(block(270, 100, 50), sheet, machine);
  ASSERT_FALSE(wide);
  EXPECT_EQ(wide.error().code, Code::does_not_fit);
  EXPECT_EQ(wide.error().where, "machine.window_width_mm");
  EXPECT_NE(wide.error().text().find("the mold is 270.0 mm wide and with 7.0 mm of room on each side is 4.0 "
                                     "mm too large for the window of 280.0 mm"),
            std::string::npos)
      << wide.error().text();
  EXPECT_NE(wide.error().fix.find("at least 284.0 mm"), std::string::npos);
  EXPECT_EQ(check_fit(block(100, 270, 50), sheet, machine).error().where, "machine.window_height_mm");

  machine.window = WindowShape::circle;
  const auto round = check_fit(block(220, 220, 50), sheet, machine);  // reaches 155.6 mm
  ASSERT_FALSE(round);
  EXPECT_NE(round.error().text().find(
                "reaches 155.6 mm from the middle and with 7.0 mm of room is 22.6 mm too wide"),
            std::string::npos)
      << round.error().text();
  EXPECT_TRUE(check_fit(block(180, 180, 50), sheet, machine));
}

// A figurine of 45 mm that was taken for one of 450.
TEST(Fit, ProposesTheUnitsThatFitIfTheUnitWasGuessed) {
  Mold mold = block(450, 300, 200);
  mold.findings.unit = Unit::cm;
  Warning guessed{"units-guessed", "the unit was taken to be cm"};
  for (const Unit unit : {Unit::mm, Unit::in})
    guessed.proposals.push_back({{{"scan.units", name(unit)}}, ""});
  mold.warnings.push_back(guessed);
  const auto refused = check_fit(mold, {}, {});
  ASSERT_FALSE(refused);
  const auto& proposals = refused.error().proposals;
  ASSERT_GE(proposals.size(), 2u);  // inches would be too large, too
  EXPECT_EQ(options_of(proposals[0]), "--set scan.units=mm");
  EXPECT_EQ(options_of(proposals[1]).find("scan.units"), std::string::npos);
  EXPECT_TRUE(refused.error().fix.starts_with("check the unit, which was guessed: --set scan.units=mm; or "))
      << refused.error().fix;
}

// The settings that a refusal proposes, taken over.
TEST(Fit, TheProposalOfARefusalWorks) {
  for (const WindowShape shape : {WindowShape::rectangle, WindowShape::circle})
    for (const Mold& mold : {block(350, 120, 60), block(120, 350.3, 60), block(400, 410, 200)}) {
      SheetSettings sheet;
      MachineSettings machine;
      machine.window = shape;
      const auto refused = check_fit(mold, sheet, machine);
      ASSERT_FALSE(refused);
      const std::string& fix = refused.error().fix;
      const auto take = [&](const std::string& name, double& value) {
        if (const auto at = fix.find("--set " + name + "="); at != std::string::npos)
          value = std::stod(fix.substr(at + 7 + name.size()));
      };
      take("machine.window_width_mm", machine.window_width_mm);
      take("machine.window_height_mm", machine.window_height_mm);
      take("sheet.width_mm", sheet.width_mm);
      take("sheet.height_mm", sheet.height_mm);
      const auto fits = check_fit(mold, sheet, machine);
      EXPECT_TRUE(fits) << fix << ": " << fits.error().text();
      EXPECT_EQ(sheet.width_mm - machine.window_width_mm, 20) << fix;
    }
  EXPECT_EQ(check_fit(block(1995, 10, 10), {}, {}).error().fix.find("--set"), std::string::npos);
}

// The settings of a proposal are merged as a client does it. A higher trim makes another mold and is left out.
TEST(Fit, EachProposalLeadsToAFitInOneStep) {
  Settings high_frame, small_sheet, small_round;
  high_frame.machine.drape_height_mm = 80;  // above the top, and the mold is too wide besides
  small_sheet.sheet.width_mm = 250;         // smaller than the window
  small_round.machine.window = WindowShape::circle;
  small_round.machine.window_width_mm = 200;
  const std::tuple<const char*, Mold, Settings> rows[] = {{"frame", block(350, 120, 60), high_frame},
                                                          {"sheet", block(300, 290, 60), small_sheet},
                                                          {"draw", block(100, 100, 450), Settings()},
                                                          {"round", block(150, 140, 60), small_round}};
  for (const auto& [name, mold, settings] : rows) {
    const auto refused = check_fit(mold, settings.sheet, settings.machine);
    ASSERT_FALSE(refused) << name;
    ASSERT_FALSE(refused.error().proposals.empty()) << name << ": " << refused.error().text();
    for (const Proposal& proposal : refused.error().proposals) {
      EXPECT_NE(refused.error().fix.find(options_of(proposal)), std::string::npos) << refused.error().fix;
      if (proposal.set.front().name == "scan.trim_mm") continue;
      auto json = nlohmann::json(to_json(settings));
      json.merge_patch(nlohmann::json(proposals_json(std::vector{proposal})[0]["set"]));
      const auto merged = settings_from_json(json);
      ASSERT_TRUE(merged) << merged.error().text();
      EXPECT_TRUE(check_fit(mold, merged->sheet, merged->machine)) << name << ": " << options_of(proposal);
    }
  }
  EXPECT_EQ(check_fit(block(100, 100, 450), {}, {}).error().proposals.size(), 2u);  // a trim, or a window
}

TEST(Fit, TakesAMoldBesideTheMiddleByItsFartherSide) {
  Mold aside = block(200, 100, 50);
  for (auto& p : aside.mesh.vertices) p.x() += 35.04;
  const auto wide = check_fit(aside, {}, {});
  ASSERT_FALSE(wide);
  EXPECT_NE(wide.error().what.find("200.0 mm wide, reaches 135.0 mm from the middle"), std::string::npos)
      << wide.error().text();
  EXPECT_NE(wide.error().fix.find("at least 284.1 mm"), std::string::npos) << wide.error().fix;
  SheetSettings sheet;
  MachineSettings machine;
  sheet.width_mm = machine.window_width_mm = 284.1;  // as proposed
  EXPECT_TRUE(check_fit(aside, sheet, machine));
}

TEST(Fit, KnowsTheDrawAndTheFrame) {
  const SheetSettings sheet;
  MachineSettings machine;
  const auto tall = check_fit(block(100, 100, 450), sheet, machine);
  ASSERT_FALSE(tall);
  EXPECT_EQ(tall.error().where, "scan.trim_mm");
  EXPECT_NE(tall.error().text().find("the draw of the mold is 450.0 mm, 30.0 mm more"), std::string::npos)
      << tall.error().text();
  EXPECT_NE(tall.error().fix.find("--set scan.trim_mm=30"), std::string::npos) << tall.error().fix;
  EXPECT_TRUE(check_fit(block(100, 100, 420), sheet, machine));
  machine.drape_height_mm = 60;
  const auto high = check_fit(block(100, 100, 50), sheet, machine);
  ASSERT_FALSE(high);
  EXPECT_EQ(high.error().where, "machine.drape_height_mm");
  EXPECT_NE(high.error().text().find("10.0 mm above the mold's top"), std::string::npos)
      << high.error().text();
  machine = {};
  machine.window_width_mm = 320;
  EXPECT_NE(check_fit(block(10, 10, 10), sheet, machine).error().text().find("larger than the sheet"),
            std::string::npos);
}

TEST(Fit, HasNothingToSayOfRoomEnough) {
  EXPECT_TRUE(fit_findings(block(120, 100, 60), {}, {}, 0.3).empty());
}

TEST(Fit, SaysWhereTheWindowIsClose) {
  // 30 mm of sheet for a wall of 100 mm: 30 / 130 of the thickness; 42.9 mm would keep 30 %.
  const auto found = fit_findings(block(220, 150, 100), {}, {}, 0.3);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "window-close");
  EXPECT_NE(found[0].text.find("the 30.0 mm of sheet between them have 100.0 mm to go down and thin to about "
                               "23 % of their thickness"),
            std::string::npos)
      << found[0].text;
  EXPECT_NE(found[0].fix.find("42.9 mm"), std::string::npos) << found[0].fix;
  ASSERT_EQ(found[0].marks.size(), 1u);
  EXPECT_EQ(std::abs(found[0].marks[0].place_mm[0]), 110);
  EXPECT_EQ(found[0].marks[0].place_mm[2], 100);
  EXPECT_EQ(found[0].marks[0].size_mm, 30);
  EXPECT_TRUE(fit_findings(block(220, 150, 100), {}, {}, 0.2).empty());
  MachineSettings raised;  // a frame that stops higher draws less: 30 / 90
  raised.drape_height_mm = 40;
  EXPECT_TRUE(fit_findings(block(220, 150, 100), {}, raised, 0.3).empty());
  MachineSettings round;  // the corners of the block are 30 mm from the ring
  round.window = WindowShape::circle;
  round.window_width_mm = 2 * std::hypot(60, 80) + 60;
  EXPECT_EQ(fit_findings(block(120, 160, 100), {}, round, 0.3).at(0).marks.at(0).size_mm, 30);
}

TEST(Fit, SaysHowDeepTheDrawIs) {
  const auto deep = fit_findings(block(60, 60, 70), {}, {}, 0.1);
  ASSERT_EQ(deep.size(), 1u);
  EXPECT_EQ(deep[0].code, "deep-draw");
  EXPECT_NE(deep[0].text.find("70.0 mm is 25 % of the window's shorter side and 117 % of the mold's"),
            std::string::npos)
      << deep[0].text;
  EXPECT_EQ(deep[0].marks.at(0).size_mm, 70);
  EXPECT_EQ(deep[0].text.find("larger window"), std::string::npos);  // which would only web more
  EXPECT_TRUE(fit_findings(block(60, 60, 59), {}, {}, 0.1).empty());
  EXPECT_EQ(fit_findings(block(160, 160, 141), {}, {}, 0.1).at(0).code, "deep-draw");
}

TEST(Fit, SaysWhenTheClampHoldsLittle) {
  SheetSettings sheet;
  sheet.height_mm = 286;
  const auto narrow = fit_findings(block(60, 60, 50), sheet, {}, 0.3);
  ASSERT_EQ(narrow.size(), 1u);
  EXPECT_EQ(narrow[0].code, "clamp-narrow");
  EXPECT_NE(narrow[0].text.find("Only 3.0 mm of the sheet lie in the clamp on the front and the back"),
            std::string::npos)
      << narrow[0].text;
  EXPECT_EQ(narrow[0].marks.at(0).place_mm[1], 143);
}

}  // namespace
}  // namespace vacuform::scan_mold_test
