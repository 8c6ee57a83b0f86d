#include "worker/flattening/flattening.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "tests/unit/shapes.hpp"
#include "worker/flattening/chart.hpp"

namespace vacuform {
namespace {

// A sheet of (2n + 1)^2 vertices, `spacing` apart, formed by `place`, all of it on the mold but a frame of two cells.
FormedSheet sheet_of(int n, double spacing, const std::function<Eigen::Vector3d(double, double)>& place) {
  FormedSheet sheet;
  const int side = 2 * n + 1;
  for (int j = -n; j <= n; ++j)
    for (int i = -n; i <= n; ++i) {
      sheet.rest.emplace_back(i * spacing, j * spacing);
      sheet.formed.push_back(place(i * spacing, j * spacing));
      sheet.contact.push_back(std::max(std::abs(i), std::abs(j)) > n - 2 ? Contact::free : Contact::mold);
    }
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const int a = j * side + i, b = a + 1, c = b + side, d = a + side;
      sheet.triangles.push_back({a, b, c});
      sheet.triangles.push_back({a, c, d});
    }
  sheet.thickness.assign(sheet.rest.size(), 1.0);
  return sheet;
}

Mold top_at(const Eigen::Vector3d& top) {
  Mold mold;
  mold.top = top;
  return mold;
}

Result<Flattening> flat(const FormedSheet& sheet, const Eigen::Vector3d& top,
                        FlatteningMethod method = FlatteningMethod::arap, InkedFace face = InkedFace::inner) {
  FlatteningSettings settings;
  settings.method = method;
  return flatten(sheet, top_at(top), settings, face, Context{});
}

// A cylinder unrolls without distortion: the arc is the chart's coordinate, whatever the sheet's stretch was.
TEST(Flattening, CylinderUnrollsExactly) {
  constexpr double R = 40;
  const auto sheet = sheet_of(20, 1.5, [](double s, double t) {
    const double arc = 1.3 * s;
    return Eigen::Vector3d(R * std::sin(arc / R), 0.9 * t, R * std::cos(arc / R));
  });
  const auto f = flat(sheet, {0, 0, R});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_LT(f->energy, 1e-6);
  EXPECT_EQ(f->flipped, 0);
  for (std::size_t i = 0; i < sheet.rest.size(); ++i) {
    if (std::isnan(f->chart[i].x())) continue;
    // The chords of 1.95 mm of arc are shorter than the arc by a part in ten thousand.
    EXPECT_NEAR(f->chart[i].x(), 1.3 * sheet.rest[i].x(), 0.01);
    EXPECT_NEAR(f->chart[i].y(), 0.9 * sheet.rest[i].y(), 0.01);
  }
}

FormedSheet dome(double R) {
  return sheet_of(24, 2, [R](double s, double t) {
    const double r = std::hypot(s, t), polar = std::min(1.3, 1.2 * r / R);
    if (r == 0) return Eigen::Vector3d(0, 0, R);
    return Eigen::Vector3d(R * std::sin(polar) * s / r, R * std::sin(polar) * t / r, R * std::cos(polar));
  });
}

TEST(Flattening, ReachesCgalsEnergyOnADome) {
  const auto sheet = dome(60);
  const auto ours = flat(sheet, {0, 0, 60}), cgals = flat(sheet, {0, 0, 60}, FlatteningMethod::cgal_arap);
  ASSERT_TRUE(ours && cgals) << cgals.error().text();
  EXPECT_GT(ours->energy, 0.001);  // a dome cannot be flattened
  EXPECT_LT(ours->energy, 1.001 * cgals->energy);
  EXPECT_EQ(ours->flipped, 0);
  // The same flattening, vertex for vertex, once both are laid in the same way.
  double furthest = 0;
  for (std::size_t i = 0; i < sheet.rest.size(); ++i)
    if (!std::isnan(ours->chart[i].x()))
      furthest = std::max(furthest, (ours->chart[i] - cgals->chart[i]).norm());
  EXPECT_LT(furthest, 0.5);
}

TEST(Flattening, IsLaidByTheTopAndTheSheetsAxes) {
  const double R = 60;
  const Eigen::Vector3d top(R * std::sin(0.1), 0, R * std::cos(0.1));
  const auto sheet = dome(R);
  const auto f = flat(sheet, top);
  ASSERT_TRUE(f);
  EXPECT_NEAR(f->top_rest.x(), 0.1 * R / 1.2, 0.05);
  EXPECT_NEAR(f->top_rest.y(), 0, 1e-9);
  // The origin of the chart is where the sheet's point (top_rest) went; the turn against the sheet is nothing.
  double c = 0, s = 0;
  for (std::size_t i = 0; i < sheet.rest.size(); ++i) {
    if (std::isnan(f->chart[i].x())) continue;
    const Eigen::Vector2d u = f->chart[i], w = sheet.rest[i] - f->top_rest;
    if (w.norm() < 3) {
      EXPECT_LT((u - 1.2 * w).norm(), 0.2);
    }
    c += u.dot(w), s += u.x() * w.y() - u.y() * w.x();
  }
  EXPECT_NEAR(std::atan2(s, c), 0, 1e-3);
}

TEST(Flattening, OuterFaceIsAThicknessFurtherOut) {
  const auto sheet = dome(60);
  const auto inner = flat(sheet, {0, 0, 60}),
             outer = flat(sheet, {0, 0, 60}, FlatteningMethod::arap, InkedFace::outer);
  ASSERT_TRUE(inner && outer);
  for (const int k : outer->triangles)
    for (int v : sheet.triangles[k]) {
      EXPECT_NEAR(inner->inked[v].norm(), 60, 1e-9);
      EXPECT_NEAR(outer->inked[v].norm(), 61, 0.01);
    }
}

TEST(Flattening, TheLargestPartWithItsHolesFilledIsTheChart) {
  FormedSheet sheet = dome(60);
  const auto whole = flat(sheet, {0, 0, 60});
  ASSERT_TRUE(whole);
  // A pocket that the sheet bridges, away from the rim, stays in the chart; a strip of free vertices cuts it in two.
  const int side = 49;
  sheet.contact[20 * side + 30] = Contact::free;
  const auto pocket = flat(sheet, {0, 0, 60});
  ASSERT_TRUE(pocket);
  EXPECT_EQ(pocket->triangles, whole->triangles);
  for (int j = 0; j < side; ++j) sheet.contact[j * side + 36] = Contact::free;
  const auto part = flat(sheet, {0, 0, 60});
  ASSERT_TRUE(part);
  EXPECT_LT(part->triangles.size(), 0.8 * whole->triangles.size());
  for (const int k : part->triangles)
    for (int v : sheet.triangles[k]) EXPECT_LT(v % side, 36);
}

TEST(Flattening, NothingOnTheMoldIsRefused) {
  FormedSheet sheet = dome(60);
  sheet.contact.assign(sheet.contact.size(), Contact::platform);
  const auto f = flat(sheet, {0, 0, 60});
  ASSERT_FALSE(f);
  EXPECT_EQ(f.error().code, Code::unusable_surface);
}

TEST(Chart, QualityCountsFlipsAndEnergy) {
  Chart chart{
      {{0, 1, 2}, {0, 2, 3}}, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 0}, {2, 0}, {2, 1}, {0, 1}}};
  EXPECT_NEAR(chart_quality(chart).arap, 1, 1e-12);  // stretched by 2 one way: (2 - 1)^2
  EXPECT_EQ(chart_quality(chart).flipped, 0);
  chart.uv[3] = {3, 0};
  EXPECT_EQ(chart_quality(chart).flipped, 1);
}

}  // namespace
}  // namespace vacuform
