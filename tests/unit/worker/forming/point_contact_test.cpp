// Parts of the mold that are thinner than the sheet's grid, and rims between its lines: the sheet meets them, or it is said.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/mold_points.hpp"

namespace vacuform::point_contact_test {
namespace {

void add_box(TriangleMesh& mesh, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const int n = static_cast<int>(mesh.vertices.size());
  for (int k = 0; k < 8; ++k)
    mesh.vertices.push_back(
        {k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(), k & 4 ? high.z() : low.z()});
  for (const Triangle& t : {Triangle{0, 2, 1},
                            {1, 2, 3},
                            {4, 5, 6},
                            {5, 7, 6},
                            {0, 1, 4},
                            {1, 5, 4},
                            {2, 6, 3},
                            {3, 6, 7},
                            {0, 4, 2},
                            {2, 4, 6},
                            {1, 3, 5},
                            {3, 7, 5}})
    mesh.triangles.push_back({n + t[0], n + t[1], n + t[2]});
}

// A block of 60 x 60 x 20 mm with a fin on it, at x = 11 along y from -20 to 20, that is 0.8 mm thick and stands 30 mm above
// the block; watertight.
Mold block_with_fin() {
  Mold mold;
  auto& m = mold.mesh;
  const auto ring = [&](double west, double east, double half, double z) {
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(west, -half, z), Eigen::Vector3d(east, -half, z),
                                     Eigen::Vector3d(east, half, z), Eigen::Vector3d(west, half, z)})
      m.vertices.push_back(p);
  };
  ring(-30, 30, 30, 0);
  ring(-30, 30, 30, 20);
  ring(10.6, 11.4, 20, 20);
  ring(10.6, 11.4, 20, 50);
  for (int upper = 4; upper < 16;
       upper += 4)  // the walls, the top of the block around the fin, the walls of the fin
    for (int k = 0; k < 4; ++k) {
      const int next = (k + 1) % 4, lower = upper - 4;
      m.triangles.push_back({lower + k, lower + next, upper + next});
      m.triangles.push_back({lower + k, upper + next, upper + k});
    }
  m.triangles.push_back({12, 13, 14});
  m.triangles.push_back({12, 14, 15});
  m.triangles.push_back({0, 2, 1});
  m.triangles.push_back({0, 3, 2});
  mold.top = {11, 0, 50};
  return mold;
}

SheetSettings sheet_of(double resolution_mm) {
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = 200;
  sheet.resolution_mm = resolution_mm;
  return sheet;
}
MachineSettings machine() {
  MachineSettings machine;
  machine.window_width_mm = machine.window_height_mm = 180;
  return machine;
}

bool warns(const FormedSheet& sheet, const std::string& code) {
  return std::any_of(sheet.warnings.begin(), sheet.warnings.end(),
                     [&](const Warning& w) { return w.code == code; });
}

TEST(MoldPoints, AreTheSharpEdgesOfABoxAndNotItsFaces) {
  TriangleMesh box;
  add_box(box, {0, 0, 0}, {10, 10, 10});
  const MoldPoints points(box, 2, 0.015);
  // Twelve edges of 10 mm at most half a millimetre apart, and the corners; the diagonals of the faces are flat.
  EXPECT_EQ(points.size(), 12u * 19u + 8u);
  int near_corner = 0;
  points.in_box({9.6, 9.6, 9.6}, {11, 11, 11},
                [&](int k) { near_corner += points.place(k).minCoeff() > 9.7; });
  EXPECT_EQ(near_corner, 1);
}

TEST(PointContact, AFinThinnerThanTheGridHoldsTheSheetUp) {
  for (const double resolution : {3.0, 2.0}) {
    const auto formed =
        form(block_with_fin(), sheet_of(resolution), machine(), {}, TemperatureField(140), Context{});
    ASSERT_TRUE(formed) << formed.error().text();
    double top = 0;
    for (const auto& p : formed->formed) top = std::max(top, p.z());
    EXPECT_NEAR(top, 50, 0.05) << resolution;
    EXPECT_LT(formed->fit.penetration.max, 0.5)
        << formed->fit.penetration.place.transpose() << " at " << resolution;
    EXPECT_LT(formed->fit.penetration.p99, 0.05);
    EXPECT_LT(formed->summary.mass_error, 1e-9);
    EXPECT_FALSE(warns(*formed, "pierced"));
    for (const Triangle& t : formed->triangles) {
      const Eigen::Vector2d a = formed->rest[t[1]] - formed->rest[t[0]],
                            b = formed->rest[t[2]] - formed->rest[t[0]];
      ASSERT_GT(a.x() * b.y() - a.y() * b.x(), 0);  // no triangle of the flat sheet is turned over
    }
  }
}

TEST(PointContact, TheSheetBendsAtARimAndNotBesideIt) {
  Mold block;
  add_box(block.mesh, {-30.7, -30.3, 0}, {30.7, 30.3, 40});  // its rims lie between the lines of the grid
  block.top = {0, 0, 40};
  const auto formed = form(block, sheet_of(2), machine(), {}, TemperatureField(140), Context{});
  ASSERT_TRUE(formed) << formed.error().text();
  EXPECT_LT(formed->fit.penetration.p99, 0.05) << formed->fit.penetration.place.transpose();
  EXPECT_LT(formed->fit.penetration.max, 0.3) << formed->fit.penetration.place.transpose();
}

// Rims of 25 to 90 degrees, off the centre and turned against the grid, of round and of angular molds.
class Rim : public testing::TestWithParam<double> {};
TEST_P(Rim, IsTouchedWithinATenthOfAMillimetre) {
  const double degrees = GetParam(), height = 24;
  const double top = 34,
               base = top + (degrees < 90 ? height / std::tan(degrees * std::numbers::pi / 180) : 0);
  for (const int sides : {5, 200})
    for (const double resolution : {3.0, 2.0}) {
      const Mold mold = frustum(base, top, height, sides, {3.3, -1.7}, 0.3);
      const auto formed = form(mold, sheet_of(resolution), machine(), {}, TemperatureField(140), Context{});
      ASSERT_TRUE(formed) << formed.error().text();
      EXPECT_LE(formed->fit.penetration.max, 0.1)
          << sides << " sides, " << resolution << " mm, at " << formed->fit.penetration.place.transpose();
      EXPECT_FALSE(warns(*formed, "pierced"));
      EXPECT_LT(formed->summary.mass_error, 1e-9);
    }
}
INSTANTIATE_TEST_SUITE_P(Degrees, Rim, testing::Values(25.0, 45.0, 65.0, 90.0));

TEST(PointContact, NamesThePlaceWhereTheMoldPiercesTheSheet) {
  FormingSettings springs;  // whose contact is that of its vertices alone
  springs.model = FormingModel::projection;
  const auto formed =
      form(block_with_fin(), sheet_of(4), machine(), springs, TemperatureField(140), Context{});
  ASSERT_TRUE(formed) << formed.error().text();
  ASSERT_GT(formed->fit.penetration.max, 10);
  ASSERT_TRUE(warns(*formed, "pierced"));
  const auto warning = std::find_if(formed->warnings.begin(), formed->warnings.end(),
                                    [](const Warning& w) { return w.code == "pierced"; });
  EXPECT_EQ(warning->severity(), Severity::serious);
  ASSERT_FALSE(warning->marks.empty());
  EXPECT_NEAR(warning->marks.front().place_mm[0], 11, 1);
  EXPECT_NEAR(warning->marks.front().place_mm[2], 50, 1);
  ASSERT_TRUE(warning->figure);
  EXPECT_EQ(warning->figure->value, formed->fit.penetration.max);
}

}  // namespace
}  // namespace vacuform::point_contact_test
