#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/numerics/rigid_fit.hpp"
#include "worker/stage/sub_progress.hpp"
#include "worker/studies/convergence.hpp"
#include "worker/studies/measured_grid.hpp"
#include "worker/studies/sensitivity.hpp"

namespace vacuform {
namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(SubProgress, MovesTheWholeAndIsCancelledWithIt) {
  std::vector<double> heard;
  Context whole([&](Stage stage, double fraction) {
    EXPECT_EQ(stage, Stage::forming);
    heard.push_back(fraction);
  });
  const SubProgress part(whole, {Stage::forming, 0.25, 0.75});
  EXPECT_TRUE(part.context().step(Stage::scan, 0));
  EXPECT_TRUE(part.context().step(Stage::forming, 0.5));
  whole.cancel();
  EXPECT_FALSE(part.context().silent().step(Stage::forming, 1));  // also where nothing is reported
  EXPECT_FALSE(part.context().step(Stage::forming, 1));
  EXPECT_EQ(heard, (std::vector<double>{0.25, 0.5}));
  Context other;
  const SubProgress beside(other, {Stage::forming, 0, 1});
  Context(beside.context()).cancel();
  EXPECT_FALSE(other.cancelled());
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
  EXPECT_FALSE(points.error().fix.empty());
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

TEST(CoilCentres, AreFoundForGroupsShapesAndLayers) {
  const std::string_view svg =
      "<svg xmlns='http://www.w3.org/2000/svg' xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape' "
      "width='100mm' height='60mm' viewBox='0 0 200 120'><defs><circle id='not-me' r='5'/></defs>"
      "<g id='layer1' inkscape:groupmode='layer'><g id='both'>"
      "<g id='a'><circle cx='40' cy='30' r='10' fill='none' stroke='#000'/></g>"
      "<g id='b' transform='translate(100 50)'><rect x='10' y='10' width='20' height='40'/></g></g>"
      "<ellipse id='c' cx='160' cy='100' rx='20' ry='10'/></g></svg>";
  const auto pattern = Pattern::read(bytes_of(svg), "coils.svg", {}, 72);
  ASSERT_TRUE(pattern) << pattern.error().text();
  const auto centres = coil_centres(*pattern);
  ASSERT_EQ(centres.size(), 3u);
  EXPECT_EQ(centres[0].id, "a");
  EXPECT_LT((centres[0].uv - Eigen::Vector2d(-30, 15)).norm(), 0.1);
  EXPECT_EQ(centres[1].id, "b");
  EXPECT_LT((centres[1].uv - Eigen::Vector2d(10, -10)).norm(), 0.1);
  EXPECT_EQ(centres[2].id, "c");
  EXPECT_LT((centres[2].uv - Eigen::Vector2d(30, -20)).norm(), 0.1);
}

TEST(CoilCentres, AreThoseOfConnectedInkWithoutNames) {
  const std::string_view svg =
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='60mm' viewBox='0 0 100 60'>"
      "<circle cx='70' cy='15' r='10' fill='none' stroke='#000' stroke-width='2'/><rect x='10' y='30' "
      "width='20' "
      "height='20'/><rect x='50' y='50' width='.5' height='.5'/></svg>";
  const auto pattern = Pattern::read(bytes_of(svg), "coils.svg", {}, 72);
  ASSERT_TRUE(pattern) << pattern.error().text();
  const auto centres = coil_centres(*pattern);
  ASSERT_EQ(centres.size(), 3u);
  EXPECT_EQ(centres[0].id, "coil-1");
  EXPECT_LT((centres[0].uv - Eigen::Vector2d(20, 15)).norm(), 0.2);
  EXPECT_EQ(centres[1].id, "mark-1");
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
