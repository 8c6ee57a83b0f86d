// Sheets formed over real heads at the default settings lie on them everywhere, and turn with them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tests/real/real_scans.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/scan/plug.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform::forming_test {
namespace {

FormedSheet formed_over(const Mold& mold, const MachineSettings& machine,
                        MembraneLaw law = FormingSettings{}.law) {
  FormingSettings forming;
  forming.law = law;
  auto sheet = form(mold, SheetSettings{}, machine, forming, TemperatureField(140), Context{});
  EXPECT_TRUE(sheet) << sheet.error().text();
  return *std::move(sheet);
}

class RealHead : public testing::TestWithParam<const char*> {};

TEST_P(RealHead, TouchesTheSheetBetweenItsVertices) {
  VACUFORM_READ_REAL_SCAN(scan, GetParam());
  const auto mold = make_mold(scan, GetParam(), ScanSettings{}, Context{});
  ASSERT_TRUE(mold) << mold.error().text();
  const FormedSheet sheet = formed_over(*mold, MachineSettings{});
  EXPECT_LE(sheet.fit.penetration.p99, 0.05) << sheet.fit.penetration.place.transpose();
  EXPECT_LE(sheet.fit.gap.p99, 0.05) << sheet.fit.gap.place.transpose();
}

INSTANTIATE_TEST_SUITE_P(All, RealHead,
                         testing::Values("neonate-40w.stl", "adult-scalp-ascii.ply",
                                         "adult-fsaverage-metres.obj", "child-headform-metres.stl"));

// On a plug of 30 mm a sheet that does not harden tears on a grid of 1.5 mm, and not on one of 3 mm.
TEST(RealPlug, FormsOnEveryGrid) {
  VACUFORM_READ_REAL_SCAN(scan, "neonate-40w.stl");
  auto cut = make_mold(scan, "neonate-40w.stl", ScanSettings{}, Context{});
  ASSERT_TRUE(cut) << cut.error().text();
  const auto mold = on_plug(*std::move(cut), 30);
  ASSERT_TRUE(mold) << mold.error().text();
  for (const double resolution : {3.0, 2.0, 1.5}) {
    SheetSettings plastic;
    plastic.resolution_mm = resolution;
    const auto sheet =
        form(*mold, plastic, MachineSettings{}, FormingSettings{}, TemperatureField(140), Context{});
    ASSERT_TRUE(sheet) << resolution << " mm: " << sheet.error().text();
    EXPECT_FALSE(sheet->summary.half_steps);
    // What lies on the mold: in the webs beside it the thickness still depends on the grid.
    double least = plastic.thickness_mm;
    for (std::size_t v = 0; v < sheet->formed.size(); ++v)
      if (sheet->contact[v] == Contact::mold) least = std::min(least, sheet->thickness[v]);
    EXPECT_GT(least, 0.4 * plastic.thickness_mm) << resolution << " mm";
  }
}

// The grid stays where it is: what is printed must not depend on how the head lies on it.
class RealPrint : public testing::TestWithParam<const char*> {};

void expect_turned_with_the_head(const std::string& file, MembraneLaw law, double most_mm) {
  VACUFORM_READ_REAL_SCAN(scan, file);
  const auto mold = make_mold(scan, file, ScanSettings{}, Context{});
  ASSERT_TRUE(mold) << mold.error().text();
  MachineSettings round;
  round.window = WindowShape::circle;
  const FormedSheet sheet = formed_over(*mold, round, law);
  const auto lies_on_it = [](const FormedSheet& of, const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](int v) { return of.contact[v] == Contact::mold; });
  };
  std::vector<char> printed(sheet.rest.size(), 0);  // a pattern lies on triangles that touch with all corners
  for (const Triangle& t : sheet.triangles)
    if (lies_on_it(sheet, t))
      for (const int v : t) printed[v] = 1;
  for (const double degrees : {30, 45}) {
    const Eigen::AngleAxisd turn(degrees * M_PI / 180, Eigen::Vector3d::UnitZ());
    Mold other = *mold;
    for (auto& v : other.mesh.vertices) v = turn * v;
    other.top = turn * other.top;
    const FormedSheet turned = formed_over(other, round, law);
    const PlaneLocator locator(turned.triangles, turned.rest);
    std::vector<double> distances;
    for (std::size_t i = 0; i < sheet.rest.size(); ++i) {
      if (!printed[i]) continue;
      const Eigen::Vector3d flat = turn * Eigen::Vector3d(sheet.rest[i].x(), sheet.rest[i].y(), 0);
      const auto there = locator.find(flat.head<2>());
      if (!there || !lies_on_it(turned, turned.triangles[there->triangle])) continue;
      distances.push_back(
          (interpolate(turned.triangles, *there, turned.formed) - turn * sheet.formed[i]).norm());
    }
    ASSERT_GT(distances.size(), 6000u);
    std::sort(distances.begin(), distances.end());
    EXPECT_LE(distances[distances.size() * 99 / 100], most_mm) << degrees << " degrees";
  }
}

TEST_P(RealPrint, TurnsWithTheHead) {
  expect_turned_with_the_head(GetParam(), MembraneLaw::neo_hookean, 0.05);
  expect_turned_with_the_head(GetParam(), MembraneLaw::mooney_rivlin, 0.06);
}

INSTANTIATE_TEST_SUITE_P(All, RealPrint, testing::Values("neonate-40w.stl", "adult-scalp-ascii.ply"));

}  // namespace
}  // namespace vacuform::forming_test
