// A mold on a plug.
#include <gtest/gtest.h>

#include <array>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/cutting.hpp"
#include "worker/scan/plug.hpp"

namespace vacuform::scan_plug_test {
namespace {

using namespace shapes;

Mold mold_of(TriangleMesh mesh) {
  Mold mold;
  mold.mesh = std::move(mesh);
  mold.top = mold.mesh.vertices.front();
  for (const auto& p : mold.mesh.vertices)
    if (p.z() > mold.top.z()) mold.top = p;
  return mold;
}

double base_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    double high = 0;
    for (const int v : t) high = std::max(high, mesh.vertices[static_cast<std::size_t>(v)].z());
    if (high < 1e-4) area += area_vector(mesh, t).norm();
  }
  return area;
}

// Watertight on z = 0, higher by the plug, larger by base times height, and with the same base.
void expect_on_plug(const Mold& mold, double height) {
  const double area = base_area(mold.mesh);
  const auto raised = on_plug(mold, height);
  ASSERT_TRUE(raised) << raised.error().text();
  EXPECT_TRUE(is_watertight(raised->mesh));
  EXPECT_EQ(bounds(raised->mesh).low.z(), 0);
  EXPECT_NEAR(bounds(raised->mesh).high.z(), bounds(mold.mesh).high.z() + height, 1e-4);
  EXPECT_EQ(raised->top.z(), bounds(raised->mesh).high.z());
  EXPECT_NEAR(signed_volume(raised->mesh), signed_volume(mold.mesh) + area * height,
              1e-6 * signed_volume(raised->mesh));
  EXPECT_NEAR(base_area(raised->mesh), area, 1e-9 * area);
}

TEST(Plug, WithoutHeightChangesNothing) {
  const Mold mold = mold_of(cube(30));
  const auto same = on_plug(mold, 0);
  ASSERT_TRUE(same);
  EXPECT_EQ(stl_bytes(same->mesh), stl_bytes(mold.mesh));
}

TEST(Plug, RaisesABoxBySixtyMillimetres) {
  const Mold mold = mold_of(box({-20, -10, 0}, {20, 10, 30}));
  expect_on_plug(mold, 60);
  EXPECT_NEAR(signed_volume(on_plug(mold, 60)->mesh), 40 * 20 * 90, 1e-3);
}

TEST(Plug, HasTheOutlineOfACutHead) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  const auto mold = make_mold(stl(sphere(50)), "head.stl", settings, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  expect_on_plug(*mold, 37.3);
}

// A ring lies on the platform with an outline and a hole; two of them with two of each.
TEST(Plug, KeepsHolesAndSeveralOutlines) {
  TriangleMesh ring;
  constexpr int n = 48;
  for (const auto& [radius, z] : {std::pair{30.0, 0.0}, {50.0, 0.0}, {45.0, 25.0}, {35.0, 25.0}})
    for (int i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      ring.vertices.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
    }
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < n; ++i) {
      const int a = k * n + i, b = k * n + (i + 1) % n, next = (k + 1) % 4 * n;
      ring.triangles.push_back({a, next + i, next + (i + 1) % n});
      ring.triangles.push_back({a, next + (i + 1) % n, b});
    }
  if (signed_volume(ring) < 0) ring = turned_over(ring);
  ASSERT_TRUE(is_watertight(ring));
  expect_on_plug(mold_of(ring), 20);
  const auto raised = on_plug(mold_of(ring), 20);
  std::vector<int> pieces;
  EXPECT_EQ(connected_pieces(raised->mesh, pieces), 1);
  EXPECT_NEAR(base_area(raised->mesh), (50 * 50 - 30 * 30) * n / 2 * std::sin(2 * std::numbers::pi / n),
              1e-6);
  expect_on_plug(mold_of(joined(shifted(ring, -60, 0, 0), shifted(ring, 60, 0, 0))), 20);
}

// Two boxes that share one vertex on the platform: four walls would meet in one edge below it.
TEST(Plug, StaysWatertightWhereOutlinesTouch) {
  TriangleMesh two = joined(box({-20, -20, 0}, {0, 0, 20}), box({0, 0, 0}, {20, 20, 20}));
  for (auto& t : two.triangles)
    for (int& v : t)
      if (v == 8) v = 3;  // both are (0, 0, 0)
  drop_unused_vertices(two);
  ASSERT_TRUE(is_watertight(two));
  expect_on_plug(mold_of(two), 15);
}

TEST(Plug, MovesTheUndercutsAndWhatIsSaidOfThem) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.trim_mm = 0;
  const auto mold = make_mold(stl(mushroom(30)), "mushroom.stl", settings, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  ASSERT_EQ(mold->undercuts.size(), 1u);
  const auto raised = on_plug(*mold, 50);
  ASSERT_TRUE(raised) << raised.error().text();
  EXPECT_NEAR(raised->undercuts[0].place.z(), mold->undercuts[0].place.z() + 50, 1e-9);
  ASSERT_EQ(raised->warnings.size(), mold->warnings.size());
  const Warning &before = mold->warnings.back(), &after = raised->warnings.back();
  ASSERT_EQ(before.code, "undercut");
  ASSERT_EQ(before.marks.size(), 1u);
  EXPECT_NEAR(before.marks[0].size_mm, 25, 1);
  EXPECT_NEAR(std::hypot(before.marks[0].place_mm[0], before.marks[0].place_mm[1]), 15, 1);
  EXPECT_NEAR(after.marks[0].place_mm[2], before.marks[0].place_mm[2] + 50, 1e-9);
  EXPECT_NE(after.text, before.text);  // it says the height
}

TEST(Plug, MovesTheMarksOfAllWarnings) {
  Mold mold = mold_of(box({-20, -20, 0}, {20, 20, 30}));
  mold.warnings.push_back({"trim-discards", "The automatic trim cuts much off.", {{{5, 6, 0}, 3}}});
  const auto raised = on_plug(mold, 50);
  ASSERT_TRUE(raised) << raised.error().text();
  ASSERT_EQ(raised->warnings.size(), 1u);
  EXPECT_EQ(raised->warnings[0].marks[0].place_mm, (std::array<double, 3>{5, 6, 50}));
  EXPECT_EQ(raised->warnings[0].text, mold.warnings[0].text);
}

TEST(Plug, NeedsABase) {
  const auto refused = on_plug(mold_of(shifted(sphere(40), 0, 0, 40)), 30);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::unusable_scan);
  EXPECT_EQ(refused.error().where, "machine.plug_height_mm");
}

}  // namespace
}  // namespace vacuform::scan_plug_test
