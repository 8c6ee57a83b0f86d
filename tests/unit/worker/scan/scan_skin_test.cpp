// From triangles to one upright skin in millimetres: pieces, orientation, up axis.
#include <gtest/gtest.h>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/outliers.hpp"
#include "worker/scan/shells.hpp"
#include "worker/scan/sides.hpp"
#include "worker/scan/upright.hpp"
#include "worker/scan/welding.hpp"

namespace vacuform::scan_skin_test {
namespace {

using namespace shapes;

constexpr double pi = std::numbers::pi;
const Context quiet;

Result<Mold> mold_of(const TriangleMesh& mesh, const ScanSettings& settings = {}) {
  return make_mold(stl(mesh), "scan.stl", settings, quiet);
}
// Trimmed at nothing, so that volumes and sizes are the scan's own.
ScanSettings whole() {
  ScanSettings settings;
  settings.trim_mm = 0;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  return settings;
}
bool warns(const Mold& mold, const std::string& code) {
  for (const auto& w : mold.warnings)
    if (w.code == code) return true;
  return false;
}

TEST(Welding, JoinsWithinTheToleranceOnly) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.0009, 0, 0}, {1, 0, 0.0009}, {0, 1.002, 0}},
                    {{0, 1, 2}, {3, 5, 4}}};
  weld(mesh, 0.001);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 3, 1}}));
}

TEST(Welding, DropsTrianglesWithoutAreaAndRepeatedOnes) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {9, 9, 9}},
                    {{0, 1, 2}, {1, 2, 3}, {2, 1, 0}, {0, 3, 1}}};
  weld(mesh, 0);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_EQ(mesh.vertices.size(), 3u);
}

TEST(Topology, BorderLoopsCloseWithTheirOwnTriangle) {
  auto mesh = cube(1);
  mesh.triangles.pop_back();
  const auto loops = border_loops(mesh);
  ASSERT_EQ(loops.size(), 1u);
  ASSERT_EQ(loops[0].size(), 3u);
  mesh.triangles.push_back({loops[0][0], loops[0][1], loops[0][2]});
  EXPECT_TRUE(is_watertight(mesh));
}

TEST(Topology, ABowTieGivesTwoLoops) {
  // Two triangles that share one corner: five edges of... each is a loop of its own.
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}};
  const auto loops = border_loops(mesh);
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(loops[0].size(), 3u);
  EXPECT_EQ(loops[1].size(), 3u);
}

TEST(Topology, WatertightMeansEveryEdgeTwiceInOppositeDirections) {
  EXPECT_TRUE(is_watertight(cube(1)));
  EXPECT_FALSE(is_watertight({}));
  auto open = cube(1);
  open.triangles.pop_back();
  EXPECT_FALSE(is_watertight(open));
  auto turned = cube(1);
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_FALSE(is_watertight(turned));
  auto doubled = cube(1);
  doubled.triangles.insert(doubled.triangles.end(), doubled.triangles.begin(),
                           doubled.triangles.begin() + 12);
  EXPECT_FALSE(is_watertight(doubled));
}

TEST(Outliers, AreNamedAndDropped) {
  const auto ball = sphere(100);
  auto mesh = ball;
  mesh.vertices[500] = {100, 50, 5000};
  mesh.vertices[2500] = {0, -7000.5, 0};
  const auto mold = mold_of(mesh);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.outliers_dropped, 2);
  EXPECT_EQ(mold->findings.unit, Unit::mm);
  EXPECT_NEAR(mold->findings.size_mm.z(), 200, 1);
  ASSERT_EQ(mold->warnings.front().code, "outliers");
  EXPECT_EQ(mold->warnings.front().place, "(0, -7000, 0), (100, 50, 5000) in the file's coordinates");
  EXPECT_EQ(mold->warnings.front().figure->value, 2);
  EXPECT_FALSE(warns(*mold_of(ball), "outliers"));
  // A pole with a hundredth of the vertices or more is a part of the scan.
  auto pole = joined(ball, shifted(scaled(sphere(1, 8), 10), 0, 0, 900));
  EXPECT_TRUE(drop_outliers(pole).empty());
}

// Alike on no two sides.
TriangleMesh crooked() {
  return joined(joined(lathe({{0, -40}, {60, -40}, {75, 0}, {70, 40}, {50, 70}, {20, 85}, {0, 87}}, 64),
                       box({60, -10, -40}, {90, 30, 0})),
                box({-20, 60, -40}, {10, 80, -10}));
}

TEST(Mirror, AnInsideOutScanIsAskedAbout) {
  auto settings = whole();
  const auto right = mold_of(crooked(), settings), reversed = mold_of(turned_over(crooked()), settings);
  ASSERT_TRUE(right && reversed);
  EXPECT_FALSE(warns(*right, "inside-out"));
  ASSERT_TRUE(warns(*reversed, "inside-out"));
  EXPECT_NE(reversed->warnings.front().what_to_do().find("scan.mirror=yes"), std::string::npos);
  EXPECT_EQ(reversed->warnings.front().severity(), Severity::serious);
  EXPECT_NEAR((reversed->top - right->top).norm(), 0, 1e-4);

  settings.mirror = Mirror::no;  // only its order was reversed
  EXPECT_FALSE(warns(*mold_of(turned_over(crooked()), settings), "inside-out"));

  settings.mirror = Mirror::yes;  // an export that mirrored the points alone
  const auto mirrored = mold_of(moved(crooked(), Eigen::Affine3d(Eigen::Scaling(-1.0, 1.0, 1.0))), settings);
  ASSERT_TRUE(mirrored);
  EXPECT_FALSE(warns(*mirrored, "inside-out"));
  EXPECT_TRUE(mirrored->findings.mirrored);
  EXPECT_GT(signed_volume(mirrored->mesh), 0);
  EXPECT_NEAR((bounds(mirrored->mesh).high - bounds(right->mesh).high).norm(), 0, 1e-3);
  EXPECT_NEAR((bounds(mirrored->mesh).low - bounds(right->mesh).low).norm(), 0, 1e-3);
}

TEST(Front, TheNamedSideComesToTheFront) {
  auto settings = whole();
  const auto shape = joined(box({-20, -20, 0}, {20, 20, 50}), box({-5, 15, 0}, {5, 80, 20}));  // nose at +y
  const auto assumed = mold_of(shape, settings);
  ASSERT_TRUE(assumed);
  EXPECT_TRUE(assumed->findings.front_assumed);
  EXPECT_EQ(assumed->findings.front, FrontSide::plus_y);
  const std::pair<FrontSide, double> sides[] = {
      {FrontSide::plus_y, 0}, {FrontSide::minus_x, 90}, {FrontSide::minus_y, 180}, {FrontSide::plus_x, -90}};
  for (const auto& [side, turned] : sides) {
    settings.front = side;
    const auto file =
        moved(shape, Eigen::Affine3d(Eigen::AngleAxisd(turned * pi / 180, Eigen::Vector3d::UnitZ())));
    const auto mold = mold_of(file, settings);
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.front, side);
    EXPECT_FALSE(mold->findings.front_assumed);
    EXPECT_NEAR((bounds(mold->mesh).high - bounds(assumed->mesh).high).norm(), 0, 1e-3) << name(side);
  }
}

// A box with a nose at +z of the file, an ear at +x, and +y up, as glTF defines them: the patient's left ear is at +x.
TEST(Front, GltfSaysThatPlusZIsTheFront) {
  const auto figure = joined(joined(box({-20, 0, -20}, {20, 50, 20}), box({-5, 10, 15}, {5, 20, 80})),
                             box({15, 20, -3}, {30, 30, 3}));
  auto settings = whole();
  settings.up = UpAxis::automatic;
  struct Row {
    UpAxis up;
    Mirror mirror;
    double roll_deg;
    FrontSide front;
    bool told;
  };
  for (const Row& row : {Row{UpAxis::automatic, Mirror::automatic, 0, FrontSide::minus_y, true},
                         Row{UpAxis::plus_y, Mirror::automatic, 17, FrontSide::minus_y, true},
                         Row{UpAxis::plus_y, Mirror::yes, 0, FrontSide::minus_y, true},
                         Row{UpAxis::minus_y, Mirror::automatic, 0, FrontSide::plus_y, true},
                         Row{UpAxis::plus_x, Mirror::automatic, 0, FrontSide::minus_x, true},
                         Row{UpAxis::minus_x, Mirror::automatic, 0, FrontSide::plus_x, true},
                         Row{UpAxis::plus_x, Mirror::yes, 0, FrontSide::plus_x, true},
                         Row{UpAxis::plus_z, Mirror::automatic, 0, FrontSide::plus_y, false}}) {
    settings.up = row.up;
    settings.mirror = row.mirror;
    settings.roll_deg = row.roll_deg;
    const auto mold = make_mold(glb(figure), "a.glb", settings, quiet);
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.front, row.front) << name(row.up);
    EXPECT_EQ(mold->findings.front_from_format, row.told) << name(row.up);
    EXPECT_EQ(mold->findings.front_assumed, !row.told) << name(row.up);
    if (row.told) {
      const Eigen::Vector3d nose = mold->placing(Eigen::Vector3d(0, 15, 80)) - mold->placing({0, 15, 0});
      EXPECT_GT(nose.y(), 75) << name(row.up) << nose.transpose();
    }
  }
  settings = whole();
  settings.up = UpAxis::automatic;
  const auto mold = make_mold(glb(figure), "a.glb", settings, quiet);
  ASSERT_TRUE(mold);
  EXPECT_NEAR((mold->placing({30, 25, 0}) - mold->placing({0, 25, 0}) - Eigen::Vector3d(-30, 0, 0)).norm(), 0,
              1e-9);                   // the patient's left is at -x
  settings.front = FrontSide::plus_x;  // a person knows better
  const auto given = make_mold(glb(figure), "a.glb", settings, quiet);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->findings.front, FrontSide::plus_x);
  EXPECT_FALSE(given->findings.front_from_format || given->findings.front_assumed);
  // No other format defines a front.
  const auto obj_mold = make_mold(obj(figure), "a.obj", settings = whole(), quiet);
  ASSERT_TRUE(obj_mold);
  EXPECT_TRUE(obj_mold->findings.front_assumed && !obj_mold->findings.front_from_format);
}

TEST(Sides, AreInDoubtUntilAPersonSawTheLeftAtMinusX) {
  const auto joined = [](LeftSide left) {
    const SideLetters l = side_letters(left);
    return l.minus_x + " " + l.plus_x + " " + l.plus_y + " " + l.minus_y + " " + l.plus_z;
  };
  EXPECT_EQ(joined(LeftSide::minus_x), "L R A P H");
  EXPECT_EQ(joined(LeftSide::plus_x), "R L A? P? H");
  EXPECT_EQ(joined(LeftSide::unknown), "L? R? A? P? H");
}

TEST(Sides, WarnOfWhatNobodyConfirmedAndOfALeftAtPlusX) {
  const auto warned = [](LeftSide left, bool front_assumed) {
    ScanFindings findings;
    findings.left_side = left;
    findings.front_assumed = front_assumed;
    return side_warnings(findings);
  };
  for (const bool assumed : {false, true}) {
    EXPECT_TRUE(warned(LeftSide::minus_x, assumed).empty());
    const auto turned = warned(LeftSide::plus_x, assumed);
    ASSERT_EQ(turned.size(), 1u);
    EXPECT_EQ(turned[0].code, "mirrored-or-turned");
    EXPECT_NE(turned[0].what_to_do().find("scan.mirror=yes"), std::string::npos);
    const auto unconfirmed = warned(LeftSide::unknown, assumed);
    ASSERT_EQ(unconfirmed.size(), 1u);
    EXPECT_EQ(unconfirmed[0].code, "side-unconfirmed");
    EXPECT_EQ(unconfirmed[0].severity(), Severity::warning);
    EXPECT_EQ(unconfirmed[0].text.find("face is taken to be at +y") != std::string::npos, assumed);
  }
}

TEST(Skin, InsideOutIsTurned) {
  const auto right = mold_of(sphere(50), whole()), wrong = mold_of(turned_over(sphere(50)), whole());
  ASSERT_TRUE(right && wrong);
  EXPECT_FALSE(right->findings.turned_inside_out);
  EXPECT_TRUE(wrong->findings.turned_inside_out);
  EXPECT_GT(signed_volume(wrong->mesh), 0);
  EXPECT_NEAR(signed_volume(wrong->mesh), signed_volume(right->mesh), 1);
}

TEST(Skin, MixedDirectionsAreMadeToAgree) {
  auto mesh = sphere(50);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  const auto mold = mold_of(mesh, whole());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_FALSE(mold->findings.turned_inside_out);
  EXPECT_FALSE(mold->findings.rebuilt);
  EXPECT_TRUE(is_watertight(mold->mesh));
  EXPECT_NEAR(signed_volume(mold->mesh), 4.0 / 3 * pi * 125000, 0.01 * 4.0 / 3 * pi * 125000);
}

TEST(Skin, AnOpenSkinThatIsInsideOutIsTurnedToo) {
  const auto bowl = without(sphere(80), [](const auto& p) { return p.z() < -20; });
  const auto mold = mold_of(turned_over(bowl));
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(mold->findings.turned_inside_out);
  EXPECT_EQ(mold->findings.up, UpAxis::plus_z);
  EXPECT_EQ(mold->findings.holes_capped, 1);
}

TEST(Skin, DebrisIsDroppedAndDoesNotCountForTheSize) {
  auto mesh = sphere(100);
  for (int i = 0; i < 1000; ++i)
    mesh = joined(std::move(mesh), shifted(scaled(cube(1), 2), 300 + 9.0 * i, -400, 10 * (i % 7)));
  const auto mold = mold_of(mesh);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.components, 1001);
  EXPECT_EQ(mold->findings.components_dropped, 1000);
  EXPECT_EQ(mold->findings.unit, Unit::mm);
  EXPECT_NEAR(mold->findings.size_mm.z(), 200, 1e-3);
}

TEST(Skin,
     InnerSkinsAreDropped) {  // scalp, skull turned the other way, brain, and a tumour outside of its middle
  const auto mesh = joined(joined(joined(sphere(90, 24), turned_over(sphere(80, 24))), sphere(70, 40)),
                           shifted(sphere(20), 20, 10, 0));
  const auto mold = mold_of(mesh, whole());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.components, 4);
  EXPECT_EQ(mold->findings.components_dropped, 3);
  EXPECT_EQ(mold->mesh.triangles.size(), sphere(90, 24).triangles.size());
}

TEST(Skin, InnerSkinsOfAHeadCutOpenBelowAreDropped) {
  const auto cut = [](const auto& p) { return p.z() < -50; };
  const auto mold = mold_of(joined(without(sphere(90), cut), without(sphere(75), cut)));
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.components_dropped, 1);
  EXPECT_EQ(mold->findings.up, UpAxis::plus_z);
}

TEST(Skin, TwoPartsSideBySideAreBothKept) {
  const auto mesh = joined(box({0, 0, 0}, {60, 60, 60}), box({80, 0, 0}, {160, 60, 50}));
  const auto mold = mold_of(mesh);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.components_dropped, 0);
  EXPECT_TRUE(is_watertight(mold->mesh));
  EXPECT_NEAR(signed_volume(mold->mesh), 60 * 60 * 60 + 80 * 60 * 50, 1);
  EXPECT_EQ(mold->undercuts.size(), 0u);
}

// The share of a cone's vertices that are inside does not matter: all but its tip are.
TEST(Skin, SmallBodiesThatCrossTheMainOneAreKept) {
  const auto block = box({-60, -60, 0}, {60, 60, 40});
  const auto spike = lathe({{0, -2}, {3, -2}, {0, 6}}, 64), loose = shifted(cube(4), 100, 0, 60);
  const auto mold = mold_of(joined(joined(block, shifted(spike, 20, 10, 40)), loose), whole());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.components_dropped, 1);
  EXPECT_EQ(mold->findings.crumbs_dropped, 0);
  EXPECT_NEAR(mold->top.z(), 46, 1e-3);
  EXPECT_NEAR(bounds(mold->mesh).size().x(), 120, 1e-3);
}

TEST(Skin, SmallBodiesThatStandOnTheMainOneAreNoCrumbs) {
  const auto block = box({-60, -60, 0}, {60, 60, 40});
  const auto fin =
      box({-8, 5, 40}, {8, 6, 49});  // a twentieth of the block's diagonal and more, a tiny volume
  const auto mold = mold_of(joined(block, fin), whole());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.crumbs_dropped, 0);
  EXPECT_NEAR(mold->top.z(), 49, 1e-3);
}

// A sphere and crumbs beside it.
TriangleMesh in_pieces(int pieces) {
  auto mesh = sphere(100, 64);
  mesh.vertices.reserve(3'100'000);
  for (int i = 1; i < pieces; ++i) {
    const Eigen::Vector3d at(i % 100, i / 100 % 100, i / 10000 + 150);
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(),
                         {at, at + Eigen::Vector3d(0.3, 0, 0), at + Eigen::Vector3d(0, 0.3, 0)});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TEST(Skin, AMillionPiecesAndNotOneMore) {
  const auto skin = outer_skin(in_pieces(1'000'000), BodyChoice::automatic, ScanProgress(quiet));
  ASSERT_TRUE(skin);
  EXPECT_EQ(skin->components, 1'000'000);
  EXPECT_EQ(skin->components_dropped, 999'999);
  EXPECT_EQ(skin->mesh.triangles.size(), sphere(100, 64).triangles.size());
  const auto more = outer_skin(in_pieces(1'000'001), BodyChoice::automatic, ScanProgress(quiet));
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, Code::too_large);
}

const std::array<std::pair<UpAxis, Eigen::Vector3d>, 6> axes{{{UpAxis::plus_x, {1, 0, 0}},
                                                              {UpAxis::minus_x, {-1, 0, 0}},
                                                              {UpAxis::plus_y, {0, 1, 0}},
                                                              {UpAxis::minus_y, {0, -1, 0}},
                                                              {UpAxis::plus_z, {0, 0, 1}},
                                                              {UpAxis::minus_z, {0, 0, -1}}}};

TEST(Up, TheTurnIsARotationThatBringsTheAxisUp) {
  for (const auto& [axis, direction] : axes) {
    const Eigen::Matrix3d turn = upright_turn(axis, 0, 0, 0);
    EXPECT_EQ(turn * direction, Eigen::Vector3d(0, 0, 1)) << name(axis);
    EXPECT_EQ(turn.determinant(), 1) << name(axis);
  }
  // Roll about x, then pitch about y, then yaw about z.
  EXPECT_NEAR(
      (upright_turn(UpAxis::plus_z, 90, 0, 0) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(),
      0, 1e-12);
  EXPECT_NEAR(
      (upright_turn(UpAxis::plus_z, 90, 90, 0) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitX()).norm(),
      0, 1e-12);
  EXPECT_NEAR(
      (upright_turn(UpAxis::plus_z, 90, 90, 90) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitY()).norm(),
      0, 1e-12);
}

TEST(Up, AnOpeningLiesOnThePlatform) {
  const auto bowl = without(sphere(80), [](const auto& p) { return p.z() < -30; });
  for (const auto& [axis, direction] : axes) {
    const auto mold = mold_of(fallen(bowl, direction));
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.up, axis) << name(axis);
    EXPECT_TRUE(mold->findings.up_guessed);
    EXPECT_FALSE(warns(*mold, "up-guessed"));
    EXPECT_EQ(mold->findings.holes_capped, 1);
  }
}

TEST(Up, AHoleIsNoFoot) {
  // Open at a narrow top, flat below.
  const auto bottle = lathe({{0, -40}, {60, -40}, {75, 0}, {70, 40}, {30, 60}, {18, 80}, {18, 100}}, 64);
  for (const auto& [axis, direction] : axes) {
    const auto mold = mold_of(fallen(bottle, direction));
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.up, axis) << name(axis);
  }
}

TEST(Up, SeveralFlatSidesAreWarnedOf) {
  auto mesh = box({-50, -30, 0}, {50, 30, 90});  // wider sides than its foot, and a fin on top
  mesh = joined(mesh, box({-2, -25, 89}, {2, 25, 110}));
  for (const auto& [axis, direction] : axes) {
    const auto mold = mold_of(fallen(mesh, direction));
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_TRUE(warns(*mold, "up-guessed")) << name(axis);
  }
}

TEST(Up, HolesAllOverAreNoOpening) {
  const auto cut = lathe({{0, -40}, {60, -40}, {75, 0}, {70, 40}, {50, 70}, {20, 85}, {0, 87}}, 64);
  for (const auto& [axis, direction] : axes) {
    auto torn = fallen(cut, direction);
    std::erase_if(torn.triangles,
                  [&, i = 0u](const Triangle&) mutable { return i++ * 2654435761u % 100 < 30; });
    const auto mold = mold_of(torn);
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.up, axis) << name(axis);
    EXPECT_TRUE(warns(*mold, "up-guessed")) << name(axis);
  }
}

TEST(Up, IsPlusYInGltf) {
  const auto upright =
      fallen(lathe({{0, -40}, {60, -40}, {75, 0}, {70, 40}, {50, 70}, {20, 85}, {0, 87}}, 24),
             Eigen::Vector3d::UnitY());
  const auto mold = make_mold(glb(upright), "scan.glb", {}, quiet);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.up, UpAxis::plus_y);
  EXPECT_FALSE(mold->findings.up_guessed);
  EXPECT_FALSE(warns(*mold, "up-guessed"));
  // A ball tells nothing; a head that lies on its side by its flat cut is doubted.
  const auto ball = make_mold(glb(sphere(100, 12)), "scan.glb", {}, quiet);
  ASSERT_TRUE(ball) << ball.error().text();
  EXPECT_EQ(ball->findings.up, UpAxis::plus_y);
  EXPECT_FALSE(warns(*ball, "up-guessed"));
  const auto along_z = lathe({{0, -40}, {60, -40}, {75, 0}, {70, 40}, {50, 70}, {20, 85}, {0, 87}}, 24);
  ScanSettings untrimmed;
  untrimmed.trim_mm = 10;
  const auto lying = make_mold(glb(along_z), "scan.glb", untrimmed, quiet);
  ASSERT_TRUE(lying) << lying.error().text();
  EXPECT_EQ(lying->findings.up, UpAxis::plus_y);
  EXPECT_TRUE(warns(*lying, "up-guessed"));
}

TEST(Up, AFlatCutLiesOnThePlatform) {
  const auto cut = lathe({{0, -40}, {60, -40}, {75, 0}, {70, 40}, {50, 70}, {20, 85}, {0, 87}}, 64);
  for (const auto& [axis, direction] : axes) {
    const auto mold = mold_of(fallen(cut, direction));
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.up, axis) << name(axis);
    EXPECT_FALSE(warns(*mold, "up-guessed"));
  }
}

TEST(Up, WarnsWhenTheShapeDoesNotTell) {
  const auto mold = mold_of(sphere(100));
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.up, UpAxis::plus_z);
  EXPECT_TRUE(warns(*mold, "up-guessed"));
  ScanSettings settings;
  settings.up = UpAxis::minus_x;
  const auto given = mold_of(sphere(100), settings);
  ASSERT_TRUE(given) << given.error().text();
  EXPECT_EQ(given->findings.up, UpAxis::minus_x);
  EXPECT_FALSE(given->findings.up_guessed);
  EXPECT_FALSE(warns(*given, "up-guessed"));
}

}  // namespace
}  // namespace vacuform::scan_skin_test
