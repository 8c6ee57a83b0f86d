#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/unit/shapes.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/studies/calibration.hpp"
#include "worker/portion.hpp"
#include "worker/studies/registration.hpp"
#include "worker/studies/sensitivity.hpp"

namespace vacuform {
namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(Portion, MovesTheWholeAndIsCancelledWithIt) {
  std::vector<double> heard;
  Context whole([&](Stage stage, double fraction) {
    EXPECT_EQ(stage, Stage::forming);
    heard.push_back(fraction);
  });
  const Portion part(whole, Stage::forming, 0.25, 0.75);
  EXPECT_TRUE(part.context().step(Stage::scan, 0));
  EXPECT_TRUE(part.context().step(Stage::forming, 0.5));
  whole.cancel();
  (void)part.context().step(Stage::forming, 1);
  EXPECT_FALSE(part.context().step(Stage::forming, 1));
  EXPECT_EQ(heard[0], 0.25);
  EXPECT_EQ(heard[1], 0.5);
}

// Two triangles of a square; a point on their common edge, on the rim, and off them.
TEST(PlaneLocator, FindsTheTriangleAndItsWeights) {
  const std::vector<Eigen::Vector2d> plane{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  const std::vector<Triangle> triangles{{0, 1, 2}, {0, 2, 3}};
  const PlaneLocator locator(triangles, plane);
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(1.5, 0.25), Eigen::Vector2d(1, 1), Eigen::Vector2d(2, 2)}) {
    const auto at = locator.find(p);
    ASSERT_TRUE(at);
    EXPECT_LT((interpolate(triangles, *at, plane) - p).norm(), 1e-12);
  }
  EXPECT_FALSE(locator.find({2.01, 1}));
  EXPECT_FALSE(locator.find({NAN, 1}));
  EXPECT_FALSE(PlaneLocator(triangles, plane, {1}).find({1.5, 0.25}));
  EXPECT_FALSE(PlaneLocator(triangles, plane, {}).find({1, 1}));
}

TEST(DistanceStatistics, AreOfAllTheDistances) {
  std::vector<double> d(100);
  for (int i = 0; i < 100; ++i) d[static_cast<std::size_t>(i)] = 100 - i;
  const auto s = statistics_of(d);
  EXPECT_EQ(s.count, 100u);
  EXPECT_DOUBLE_EQ(s.mean, 50.5);
  EXPECT_DOUBLE_EQ(s.p95, 95);
  EXPECT_DOUBLE_EQ(s.p99, 99);
  EXPECT_DOUBLE_EQ(s.max, 100);
  EXPECT_NEAR(s.rms, std::sqrt(101 * 201 / 6.0), 1e-12);
  EXPECT_EQ(statistics_of({}).max, 0);
}

TEST(RigidMotion, IsFoundExactlyAndNeverMirrors) {
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(10, -20, 300) * Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -1).normalized());
  std::vector<Eigen::Vector3d> from{{0, 0, 0}, {50, 0, 3}, {0, 40, -2}, {30, 30, 25}}, to, mirrored;
  for (const auto& p : from) to.push_back(motion * p), mirrored.push_back({-p.x(), p.y(), p.z()});
  EXPECT_LT((rigid_motion(from, to, {1, 2, 1, 0.5}).matrix() - motion.matrix()).norm(), 1e-12);
  EXPECT_NEAR(rigid_motion(from, mirrored, {1, 1, 1, 1}).linear().determinant(), 1, 1e-12);
  to[3] += Eigen::Vector3d(5, 5, 5);  // a point without weight
  EXPECT_LT((rigid_motion(from, to, {1, 1, 1, 0}).matrix() - motion.matrix()).norm(), 1e-12);
}

TEST(MeasuredGrid, IsReadByItsHeader) {
  std::string text = "\xef\xbb\xbf# a remark\r\nz_mm;\"S\";t;x;y;note\r\n";
  for (int i = 0; i < 12; ++i)
    text += "3,5;" + std::to_string(10 * i) + ";" + std::to_string(i * i) + ";1;2;ok\r\n";
  const auto points = read_measured_grid(bytes_of(text), "grid.csv", {});
  ASSERT_TRUE(points) << points.error().text();
  ASSERT_EQ(points->size(), 12u);
  EXPECT_EQ((*points)[3].rest, Eigen::Vector2d(30, 9));
  EXPECT_EQ((*points)[3].place, Eigen::Vector3d(1, 2, 3.5));
}

struct Refused {
  std::string text, what, where;
};
class MeasuredGridErrors : public testing::TestWithParam<Refused> {};
TEST_P(MeasuredGridErrors, NameTheLine) {
  const auto& [text, what, where] = GetParam();
  const auto points = read_measured_grid(bytes_of(text), "grid.csv", {});
  ASSERT_FALSE(points);
  EXPECT_NE(points.error().what.find(what), std::string::npos) << points.error().text();
  EXPECT_EQ(points.error().where, where);
  EXPECT_FALSE(points.error().mend.empty());
}
INSTANTIATE_TEST_SUITE_P(
    Files, MeasuredGridErrors,
    testing::Values(
        Refused{"", "0 measured points", "grid.csv"},
        Refused{"1,2,3,4,5\n", "no column s", "grid.csv, line 1"},
        Refused{"s,t,x,y\n", "no column z", "grid.csv, line 1"},
        Refused{"s,t,x,y,z\n1,2,3,4,5\n1,2,3,4\n", "none for z", "grid.csv, line 3"},
        Refused{"s,t,x,y,z\n\n1,2,3,4,5e\n", "\"5e\"", "grid.csv, line 3"},
        Refused{"s,t,x,y,z\n1,2,nan,4,5\n", "not a number for x", "grid.csv, line 2"},
        Refused{"s,t,x,y,z\n1,2,3,4,1e9\n", "z is", "grid.csv, line 2"},
        Refused{"s,t,x,y,z\n151,2,3,4,5\n", "off the sheet", "grid.csv, line 2"},
        Refused{"s,t,x,y,z\n1,2,3,4,5\n", "only 1 measured", "grid.csv"},
        Refused{"s,t,x,y,z\n1,1,0,0,0\n2,2,0,0,0\n3,3,0,0,0\n4,4,0,0,0\n5,5,0,0,0\n6,6,0,0,0\n7,7,0,0,"
                "0\n8,8,0,0,0\n9,9,0,0,0\n10,10,0,0,0\n",
                "one line of the sheet", "grid.csv"}));

// A machine that is not as it was said: 8 mm higher, 6 mm narrower, 4 mm less deep, half as stiff again at the frame.
// Its part is measured with 0.2 mm of noise, in a frame of its own, and some points are plainly wrong.
TEST(Calibration, RecoversASimulatedMachine) {
  const Prepared prepared{hemisphere(60, 45, 90), TemperatureField(140)};
  Settings given, real;
  given.sheet.width_mm = given.sheet.height_mm = 220;
  given.sheet.resolution_mm = 10;
  given.machine.window_width_mm = given.machine.window_height_mm = 200;
  real = given;
  real.machine.drape_height_mm = 8;
  real.machine.window_width_mm = 194, real.machine.window_height_mm = 196;
  real.forming.edge_stiffness = 1.5;
  const auto part =
      form(prepared.mold, real.sheet, real.machine, real.forming, prepared.temperature, Context{});
  ASSERT_TRUE(part) << part.error().text();
  const SheetMap map(*part);
  const Eigen::Isometry3d frame =
      Eigen::Translation3d(40, -300, 120) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 3).normalized());
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 0.2);
  std::vector<MeasuredPoint3> points;
  for (double s = -90; s <= 90; s += 10)
    for (double t = -90; t <= 90; t += 10) {
      Eigen::Vector3d place = *map({s, t});
      for (int k = 0; k < 3; ++k) place[k] += noise(random);
      if (points.size() % 50 == 7) place += Eigen::Vector3d(6, -3, 4);
      points.push_back({{s, t}, frame * place});
    }

  const auto found = calibrate(prepared, given, points, {}, Context{});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_TRUE(found->converged);
  EXPECT_GT(found->before.mean, 1);
  EXPECT_LT(found->after.mean, 0.55);  // noise of 0.2 mm in each direction is 0.32 mm; wild points add theirs
  EXPECT_EQ(found->after.count, points.size());
  EXPECT_GE(found->outliers, 7);
  ASSERT_EQ(found->parameters.size(), 4u);
  const double wanted[] = {8, 194, 196, 1.5}, within[] = {0.5, 0.7, 0.7, 0.1};
  for (std::size_t k = 0; k < 4; ++k) {
    const FittedParameter& p = found->parameters[k];
    EXPECT_NEAR(p.value, wanted[k], within[k]) << p.key;
    EXPECT_GT(p.standard_error, 0) << p.key;
    EXPECT_LT(p.standard_error, within[k]) << p.key;
    EXPECT_FALSE(p.at_bound) << p.key;
  }
  EXPECT_LT((found->motion * frame).translation().norm(), 0.5);

  const auto written =
      nlohmann::json::parse(R"({"machine": {"window_width_mm": 200, "vacuum_kpa": 60}, "print": {}})");
  const auto profile = profile_json(*found, written);
  EXPECT_EQ(profile["machine"]["vacuum_kpa"].get<double>(), 60);
  EXPECT_NEAR(profile["machine"]["window_width_mm"].get<double>(), 194, 0.7);
  EXPECT_FALSE(profile.contains("print"));
  EXPECT_EQ(profile["calibration"]["residual_mm"]["count"].get<std::size_t>(), points.size());
  auto settings = nlohmann::json::parse(profile.dump());
  settings.erase("calibration");
  EXPECT_TRUE(settings_from_json(settings));
}

TEST(Convergence, ComparesTheSamePointsOfTheSheet) {
  const Prepared prepared{hemisphere(50), TemperatureField(140)};
  Settings settings;
  settings.sheet.width_mm = settings.sheet.height_mm = 200;
  settings.machine.window_width_mm = settings.machine.window_height_mm = 180;
  settings.sheet.resolution_mm = 10;
  const auto found = converge(prepared, settings, {2, 1, 0.5}, Context{});
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->refinements.size(), 2u);
  const auto &coarse = found->refinements[0], &fine = found->refinements[1];
  EXPECT_EQ(coarse.coarse_mm, 20);
  EXPECT_EQ(fine.fine_mm, 5);
  EXPECT_LT(fine.head.mean, 0.6 * coarse.head.mean);
  EXPECT_GT(fine.head.mean, 0);
  EXPECT_LT(fine.head.count, fine.sheet.count);
  EXPECT_NEAR(fine.worst_formed.norm(), 50, 0.5);  // it lies on the mold
  ASSERT_TRUE(found->order);
  EXPECT_GT(*found->order, 0.7);
}

TEST(CoilCentres, OfGroupsShapesAndLayers) {
  const std::string_view svg =
      "<svg xmlns='http://www.w3.org/2000/svg' xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape' "
      "width='100mm' height='60mm' viewBox='0 0 200 120'><defs><circle id='not-me' r='5'/></defs>"
      "<g id='layer1' inkscape:groupmode='layer'><g id='both'>"
      "<g id='a'><circle cx='40' cy='30' r='10' fill='none' stroke='#000'/></g>"
      "<g id='b' transform='translate(100 50)'><rect x='10' y='10' width='20' height='40'/></g></g>"
      "<ellipse id='c' cx='160' cy='100' rx='20' ry='10'/></g></svg>";
  const auto pattern = Pattern::read(bytes_of(svg), "coils.svg", {}, 72);
  ASSERT_TRUE(pattern) << pattern.error().text();
  const auto centres = coil_centres(bytes_of(svg), *pattern);
  ASSERT_EQ(centres.size(), 3u);
  EXPECT_EQ(centres[0].id, "a");
  EXPECT_LT((centres[0].uv - Eigen::Vector2d(-30, 15)).norm(), 0.1);
  EXPECT_EQ(centres[1].id, "b");
  EXPECT_LT((centres[1].uv - Eigen::Vector2d(10, -10)).norm(), 0.1);
  EXPECT_EQ(centres[2].id, "c");
  EXPECT_LT((centres[2].uv - Eigen::Vector2d(30, -20)).norm(), 0.1);
}

TEST(CoilCentres, OfConnectedInkWhereNothingHasAName) {
  const std::string_view svg =
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='60mm' viewBox='0 0 100 60'>"
      "<circle cx='70' cy='15' r='10' fill='none' stroke='#000' stroke-width='2'/><rect x='10' y='30' "
      "width='20' "
      "height='20'/><rect x='50' y='50' width='.5' height='.5'/></svg>";
  const auto pattern = Pattern::read(bytes_of(svg), "coils.svg", {}, 72);
  ASSERT_TRUE(pattern) << pattern.error().text();
  const auto centres = coil_centres(bytes_of(svg), *pattern);
  ASSERT_EQ(centres.size(), 2u);
  EXPECT_EQ(centres[0].id, "ink-1");
  EXPECT_LT((centres[0].uv - Eigen::Vector2d(20, 15)).norm(), 0.2);
  EXPECT_EQ(centres[1].id, "ink-2");
  EXPECT_LT((centres[1].uv - Eigen::Vector2d(-30, -10)).norm(), 0.2);
}

// A coil at the pole stays there whatever is changed; one down the side moves, and least by the modulus.
TEST(Sensitivity, MovesCoilsBySizeOfTheError) {
  const Mold mold = hemisphere(50);
  Settings settings;
  settings.sheet.width_mm = settings.sheet.height_mm = 200;
  settings.machine.window_width_mm = settings.machine.window_height_mm = 180;
  settings.sheet.resolution_mm = 6;
  const TemperatureField temperature(140);
  const auto nominal = form(mold, settings.sheet, settings.machine, settings.forming, temperature, Context{});
  ASSERT_TRUE(nominal);
  const auto variants = form_variants(mold, settings, temperature, Context{});
  ASSERT_TRUE(variants) << variants.error().text();
  const auto table = sensitivity_json(
      *nominal, *variants, {{"pole", Eigen::Vector2d(0, 0)}, {"side", Eigen::Vector2d(0, 50)}, {"off", {}}});
  EXPECT_EQ(table["coils"].dump(), R"(["pole","side","off"])");
  std::map<std::string, double> side;
  for (const auto& change : table["changes"]) {
    ASSERT_FALSE(change["mean_mm"].is_null()) << change.dump();
    EXPECT_LT(change["coils_mm"][0].get<double>(), 0.1) << change["id"];
    EXPECT_TRUE(change["coils_mm"][2].is_null());
    side[change["id"].get<std::string>()] = change["coils_mm"][1].get<double>();
    EXPECT_EQ(change["max_mm"].get<double>(),
              std::max(change["coils_mm"][0].get<double>(), change["coils_mm"][1].get<double>()));
  }
  ASSERT_EQ(side.size(), 7u);
  EXPECT_GT(side["drape-height"], 0.1);
  EXPECT_GT(side["window"], 0.05);
  EXPECT_GT(side["edge-stiffness"], 0.1);
  EXPECT_LT(side["modulus"], 0.05);
}

}  // namespace
}  // namespace vacuform
