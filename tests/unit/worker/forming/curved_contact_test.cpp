// Between its vertices, too, the formed sheet lies on a curved mold.
#include "worker/forming/curved_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/fixtures/shapes.hpp"
#include "tests/unit/worker/forming/axisymmetric.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform::curved_contact_test {
namespace {

FormedSheet formed_over(const Mold& mold) {
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = 200;
  sheet.resolution_mm = 4;
  MachineSettings machine;
  machine.window_width_mm = machine.window_height_mm = 180;
  auto formed = form(mold, sheet, machine, FormingSettings{}, TemperatureField(140), Context{});
  EXPECT_TRUE(formed) << formed.error().text();
  return *std::move(formed);
}

// On a grid of 4 mm the middles of edges are up to 0.2 mm in a sphere of this radius.
TEST(CurvedContact, LiesOnASphereBetweenTheVertices) {
  const Mold mold = hemisphere(50, 180, 360);
  const FormedSheet sheet = formed_over(mold);
  const MoldDistance distance(mold.mesh);
  int edges = 0;
  double farthest = 0;
  for (const Triangle& t : sheet.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (a > b || sheet.contact[a] != Contact::mold || sheet.contact[b] != Contact::mold) continue;
      ++edges;
      farthest = std::max(farthest, distance((sheet.formed[a] + sheet.formed[b]) / 2));
    }
  EXPECT_GT(edges, 3000);
  EXPECT_LT(farthest, 0.08);
  EXPECT_LT(sheet.fit.penetration.p99, 0.05);
  EXPECT_LT(sheet.fit.gap.p99, 0.01);
  for (std::size_t i = 0; i < sheet.formed.size(); ++i)
    if (sheet.contact[i] == Contact::mold) {
      EXPECT_LT(distance(sheet.formed[i]), 1e-3);
    }
}

TEST(CurvedContact, KeepsTheSheetWhole) {
  const FormedSheet sheet = formed_over(hemisphere(50, 90, 180));
  double area = 0, volume = 0;
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    const Triangle& t = sheet.triangles[k];
    const double flat = cross(sheet.rest[t[1]] - sheet.rest[t[0]], sheet.rest[t[2]] - sheet.rest[t[0]]) / 2;
    EXPECT_GT(flat, 0);
    area += flat;
    const Eigen::Vector3d a = sheet.formed[t[0]], b = sheet.formed[t[1]], c = sheet.formed[t[2]];
    volume += (b - a).cross(c - a).norm() / 2 * sheet.element_thickness[k];
  }
  EXPECT_NEAR(area, 200 * 200, 1e-6);
  EXPECT_NEAR(volume, 200 * 200 * SheetSettings{}.thickness_mm, 1e-6);
  EXPECT_EQ(border_loops(sheet.triangles).size(), 1u);
  const std::size_t vertices = sheet.rest.size(), triangles = sheet.triangles.size();
  EXPECT_EQ(sheet.formed.size(), vertices);
  EXPECT_EQ(sheet.thickness.size(), vertices);
  EXPECT_EQ(sheet.temperature.size(), vertices);
  EXPECT_EQ(sheet.contact.size(), vertices);
  EXPECT_EQ(sheet.contact_time.size(), vertices);
  EXPECT_EQ(sheet.element_thickness.size(), triangles);
  EXPECT_EQ(sheet.element_wrinkled.size(), triangles);
}

// Near the foot the stretch grows by a tenth within an edge: half-way in space is not half-way on the flat sheet.
TEST(CurvedContact, ANewVertexLandsAsExactlyAsTheOthers) {
  constexpr double R = 75, ring = 1.3, degree = std::numbers::pi / 180;
  SheetSettings plastic;
  plastic.width_mm = plastic.height_mm = 2 * ring * R + 10;
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 2 * ring * R;
  FormingSettings forming;
  forming.law = MembraneLaw::neo_hookean;
  const auto sheet =
      form(hemisphere(R, 180, 360), plastic, machine, forming, TemperatureField(140), Context{});
  ASSERT_TRUE(sheet) << sheet.error().text();
  const auto landed = exact::male_hemisphere(MembraneLaw::neo_hookean, ring, 81 * degree);
  double farthest = 0;
  for (std::size_t i = 0; i < sheet->rest.size(); ++i) {
    if (sheet->contact[i] != Contact::mold) continue;
    const double polar = std::atan2(sheet->formed[i].head<2>().norm(), sheet->formed[i].z());
    if (polar < 5 * degree || polar > 80 * degree) continue;
    farthest = std::max(farthest, std::abs(sheet->rest[i].norm() - R * exact::at(landed, polar).rest));
  }
  EXPECT_LT(farthest, 0.02);  // 0.028 with the new vertices half-way
}

// What the grid cannot follow is not hidden: a step between two vertices is no curvature.
TEST(CurvedContact, LeavesWhatIsNoCurvature) {
  Mold mold = hemisphere(50, 90, 180);
  FormedSheet sheet;
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  sheet.rest = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  const Obstacles obstacles(mold.mesh, MachineSettings{});
  const auto bend = [&](double depth_mm) {
    FormedSheet low = sheet;
    for (const auto& p : sheet.rest) low.formed.emplace_back(p.x() - 2, p.y() - 2, 50 - depth_mm);
    low.contact.assign(4, Contact::mold);
    low.contact_time.assign(4, 1);
    low.temperature.assign(4, 140);
    low.element_thickness.assign(2, 1);
    low.element_wrinkled.assign(2, 0);
    bend_to_mold(low, obstacles, TemperatureField(140), 0.04);
    return low;
  };
  EXPECT_EQ(bend(0.015).triangles, sheet.triangles);  // close enough
  EXPECT_EQ(bend(2).triangles, sheet.triangles);      // too far
  const FormedSheet bent = bend(0.25);
  EXPECT_EQ(bent.triangles.size(), 4u);  // the diagonal alone has two triangles
  ASSERT_EQ(bent.formed.size(), 5u);
  EXPECT_NEAR((bent.formed[4] - Eigen::Vector3d(0, 0, 50)).norm(), 0, 1e-4);
  EXPECT_EQ(bent.rest[4], Eigen::Vector2d(2, 2));
}

}  // namespace
}  // namespace vacuform::curved_contact_test
