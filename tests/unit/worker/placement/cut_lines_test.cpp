#include "worker/placement/cut_lines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using hand_made::Sample;

double area(const FormedSheet& sheet, const std::vector<int>& triangles) {
  double sum = 0;
  for (const int t : triangles) {
    const auto at = [&](std::size_t k) {
      return sheet.formed[static_cast<std::size_t>(sheet.triangles[static_cast<std::size_t>(t)][k])];
    };
    sum += (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
  }
  return sum;
}
std::vector<int> all_of(const FormedSheet& sheet) {
  std::vector<int> out(sheet.triangles.size());
  std::iota(out.begin(), out.end(), 0);
  return out;
}
int uncut_edges_with_one_side(const FormedSheet& sheet) {
  std::map<Edge, int> sides;
  for (const Triangle& t : sheet.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
  int out = 0;
  for (const auto& [edge, count] : sides) out += count == 1;
  return out;
}

// Across a flat sheet, askew to its grid: the edges lie on the line, and nothing else has changed.
TEST(CutLines, AreStraightAndLeaveTheSurfaceAsItIs) {
  const Sample x = hand_made::flat(100, 20, 45);
  const auto cut =
      with_cut_lines(x.sheet, hand_made::inked(x.sheet), x.flattening, {{-30, -17, 0, 31, 12, 0}}, Context());
  ASSERT_TRUE(cut);
  const Vector3d a(-30, -17, 0), along = Vector3d(61, 29, 0).normalized();
  double length = 0;
  for (const auto& [p, q] : cut->edges) {
    for (const int v : {p, q}) {
      const Vector3d off = cut->sheet.formed[static_cast<std::size_t>(v)] - a;
      EXPECT_LT((off - off.dot(along) * along).norm(), 0.8);  // a tenth of an edge of 5 to 7 mm
    }
    length +=
        (cut->sheet.formed[static_cast<std::size_t>(p)] - cut->sheet.formed[static_cast<std::size_t>(q)])
            .norm();
  }
  EXPECT_NEAR(length, std::hypot(61, 29), 1.5);
  EXPECT_NEAR(area(cut->sheet, all_of(cut->sheet)), 100 * 100, 1e-6);
  EXPECT_NEAR(area(cut->sheet, cut->flattening.triangles), area(x.sheet, x.flattening.triangles), 1e-6);
  EXPECT_TRUE(std::is_sorted(cut->flattening.triangles.begin(), cut->flattening.triangles.end()));
  EXPECT_EQ(uncut_edges_with_one_side(cut->sheet), uncut_edges_with_one_side(x.sheet));  // no T-junctions
  EXPECT_EQ(cut->sheet.element_thickness.size(), cut->sheet.triangles.size());
  for (const auto& [p, q] : cut->edges)
    EXPECT_LT(
        (cut->flattening.chart[static_cast<std::size_t>(p)] - cut->sheet.rest[static_cast<std::size_t>(p)])
            .norm(),
        1e-9);
}

// Rows that share points continue, and rows that cross share a vertex: all pieces of a cross are apart.
TEST(CutLines, PartTheRegionIntoSegments) {
  Sample x = hand_made::dome(60);
  x.settings.pattern.placement = PatternPlacement::segments;
  x.settings.pattern.distortion_limit = 9;
  x.settings.pattern.seams = {{-80, 3, 0, 2, 1, 60}, {2, 1, 60, 80, 3, 0}, {0, -80, 0, 0, 80, 0}};
  const auto cut =
      with_cut_lines(x.sheet, hand_made::inked(x.sheet), x.flattening, x.settings.pattern.seams, Context());
  ASSERT_FALSE(cut);  // 20 mm off the dome's foot is too far
  EXPECT_EQ(cut.error().where, "pattern.seams");
  EXPECT_NE(cut.error().what.find("row 1"), std::string::npos);

  x.settings.pattern.seams = {{-62, 3, 10, 2, 1, 60}, {2, 1, 60, 62, 3, 10}, {0, -62, 10, 0, 62, 10}};
  const auto recut =
      with_cut_lines(x.sheet, hand_made::inked(x.sheet), x.flattening, x.settings.pattern.seams, Context());
  ASSERT_TRUE(recut) << recut.error().text();
  const auto placement =
      place(ChartedSurface(recut->surface, recut->flattening), nullptr, x.settings, Context(), recut->edges);
  ASSERT_TRUE(placement);
  EXPECT_EQ(placement->charts.size(), 4u);
  EXPECT_EQ(placement->seams.size(), 4u);
  EXPECT_TRUE(placement->warnings.empty());
  std::set<int> covered;
  for (const Segment& s : placement->charts) covered.insert(s.triangles.begin(), s.triangles.end());
  EXPECT_EQ(covered.size(), recut->flattening.triangles.size());

  // A tighter limit cuts on, and says that the cuts given did not do.
  x.settings.pattern.distortion_limit = 1.02;
  const auto finer =
      place(ChartedSurface(recut->surface, recut->flattening), nullptr, x.settings, Context(), recut->edges);
  ASSERT_TRUE(finer);
  EXPECT_GT(finer->charts.size(), 4u);
  ASSERT_FALSE(finer->warnings.empty());
  EXPECT_EQ(finer->warnings.back().code, "seams-not-enough");
}

TEST(CutLines, FromAPointToItselfAreRefused) {
  const Sample x = hand_made::flat(100, 20, 45);
  const auto cut =
      with_cut_lines(x.sheet, hand_made::inked(x.sheet), x.flattening, {{0, 0, 0, 0.1, 0, 0}}, Context());
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().code, Code::bad_settings);
}

TEST(CutLines, NoRowsChangeNothing) {
  const Sample x = hand_made::flat(100, 20, 45);
  const auto cut = with_cut_lines(x.sheet, hand_made::inked(x.sheet), x.flattening, {}, Context());
  ASSERT_TRUE(cut);
  EXPECT_TRUE(cut->edges.empty());
  EXPECT_EQ(cut->sheet.triangles, x.sheet.triangles);
}

}  // namespace
}  // namespace vacuform
