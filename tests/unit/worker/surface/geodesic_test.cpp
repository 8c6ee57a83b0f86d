#include "worker/surface/geodesic.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/placement/element_patch.hpp"
#include "worker/surface/exact_geodesics.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using hand_made::Sample;

SheetPoint at(const ChartedSurface& charted, const Vector2d& chart) { return charted.at_chart(chart).point; }

TEST(Geodesic, IsStraightOnAFlatSheetAlsoThroughVerticesAndAlongEdges) {
  const Sample x = hand_made::flat(100, 20);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  // From a vertex along a row of edges, along diagonals through vertices, and obliquely.
  for (const Vector2d& way : {Vector2d(40, 0), Vector2d(-30, 30), Vector2d(17, -33)}) {
    GeodesicWalk walk(surface, at(charted, {0, 0}), {way.x(), way.y(), 0});
    EXPECT_DOUBLE_EQ(walk.advance(way.norm()), way.norm());
    EXPECT_LT((surface.rest(walk.at()) - way).norm(), 1e-6);
    EXPECT_FALSE(walk.ended());
  }
}

TEST(Geodesic, StopsAtTheBorderOfTheSheet) {
  const Sample x = hand_made::flat(100, 20);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  GeodesicWalk walk(surface, at(charted, {11, 3}), {1, 0, 0});
  EXPECT_NEAR(walk.advance(100), 39, 1e-6);
  EXPECT_TRUE(walk.ended());
  EXPECT_EQ(walk.advance(1), 0);
  EXPECT_NEAR(surface.place(walk.at()).x(), 50, 1e-6);
}

TEST(Geodesic, FollowsTheGreatCircleOnASphere) {
  constexpr double radius = 85;
  const Sample x = hand_made::sphere(radius, 240, 120);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  const SheetPoint start = at(charted, {20.3, 10.7});  // inside of a triangle, whose plane has the directions
  const Vector3d from = surface.place(start).normalized();
  for (int i = 0; i < 12; ++i) {
    const Vector3d along =
        turned(surface, start.triangle, charted.charted.axis(start.triangle), i * M_PI / 6);
    GeodesicWalk walk(surface, start, along);
    walk.advance(60);
    const Vector3d tangent = (along - along.dot(from) * from).normalized();
    const Vector3d exact = radius * (std::cos(60 / radius) * from + std::sin(60 / radius) * tangent);
    EXPECT_LT((surface.place(walk.at()) - exact).norm(), 0.15) << i;
  }
}

TEST(Geodesic, ConnectsTwoPointsOfASphereTheShortestWay) {
  constexpr double radius = 85;
  const Sample x = hand_made::sphere(radius, 240, 120);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  const SheetPoint a = at(charted, {-30, 5}), b = at(charted, {35, 40});
  const Connection way = connect(surface, a, b);
  const Vector3d p = surface.place(a).normalized(), q = surface.place(b).normalized();
  EXPECT_TRUE(way.found);
  EXPECT_NEAR(way.mm, radius * std::acos(p.dot(q)), 0.03);
  EXPECT_LT(way.leaving.dot(p), 0.02);
  GeodesicWalk walk(surface, a, way.leaving);
  walk.advance(way.mm);
  EXPECT_LT((surface.place(walk.at()) - surface.place(b)).norm(), 0.05);
  EXPECT_EQ(connect(surface, a, a).mm, 0);
}

TEST(ElementPatch, OnASphereHasTrueAreasAndGeodesicRadii) {
  constexpr double radius = 60;
  const Sample x = hand_made::sphere(radius, 240, 160);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  const SheetPoint centre = at(charted, {20, 10});
  const auto patch =
      element_patch(charted, centre, charted.charted.axis(centre.triangle), 40, CoilKeep::area, Context());
  ASSERT_TRUE(patch);
  EXPECT_TRUE(patch->smooth);
  const ElementMap map(*patch);
  const Vector3d middle = surface.place(centre).normalized();
  for (const double drawn : {10.0, 25.0, 40.0})
    for (int i = 0; i < 30; ++i) {
      const auto place = map.place(drawn * Vector2d(std::cos(i * 0.2), std::sin(i * 0.2)));
      ASSERT_TRUE(place);
      // A cap of polar angle a has the area 4 pi R^2 sin^2(a / 2).
      const double angle = 2 * std::asin(drawn / (2 * radius));
      EXPECT_NEAR(std::acos(place->normalized().dot(middle)) / angle, 1, 0.002);
    }
}

TEST(ElementPatch, OnABumpKeepsRadiiAndTurnsNothingOver) {
  // A bump on a plane, steep enough that geodesics from beside it cross behind it.
  Sample x = hand_made::flat(160, 100);
  for (std::size_t i = 0; i < x.sheet.rest.size(); ++i) {
    const Vector2d d = x.sheet.rest[i] - Vector2d(9, 0);
    x.sheet.formed[i].z() = 8 * std::exp(-d.squaredNorm() / 30);
  }
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  const SheetPoint centre = at(charted, {0.3, 0.2});
  const auto patch =
      element_patch(charted, centre, charted.charted.axis(centre.triangle), 25, CoilKeep::area, Context());
  ASSERT_TRUE(patch);
  EXPECT_FALSE(patch->smooth);
  for (const Triangle& t : patch->patch.triangles) {
    const auto uv = [&](int k) {
      return patch->patch.uv[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    const Vector2d a = uv(1) - uv(0), b = uv(2) - uv(0);
    if (uv(0).norm() < 25) {
      EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0);
    }
  }
  // Behind the centre, the only effect on radii is the area that the bump adds, which makes them smaller in all
  // directions.
  const ElementMap map(*patch);
  double least = 1e9, most = 0;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2 * M_PI / 3 + i * M_PI / 90;
    const auto place = map.place(20 * Vector2d(std::cos(angle), std::sin(angle)));
    ASSERT_TRUE(place);
    const double r = (*place - surface.place(centre)).head<2>().norm();
    least = std::min(least, r), most = std::max(most, r);
  }
  EXPECT_LT(most / least, 1.005);
  EXPECT_LT(most, 20);
}

SheetPoint vertex(const std::vector<Triangle>& triangles, int v) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      if (triangles[t][static_cast<std::size_t>(k)] == v) return {static_cast<int>(t), Vector3d::Unit(k)};
  return {};
}

TEST(ExactGeodesics, AreStraightOnAFlatSheetAndEndAtTheReach) {
  const Sample x = hand_made::flat(100, 10);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  Geodesics geodesics(surface.path_mesh());
  geodesics.begin_at(at(charted, {1, 2}), 20);
  const auto path = geodesics.to(at(charted, {4, 6}));
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length, 5, 1e-9);
  EXPECT_LT((path->start - Vector3d(0.6, 0.8, 0)).norm(), 1e-9);
  EXPECT_NEAR(geodesics.to(at(charted, {-10, 2}))->length, 11, 1e-9);
  EXPECT_FALSE(geodesics.to(at(charted, {49, 49})));
  EXPECT_LT(geodesics.to(at(charted, {1, 2}))->length, 1e-6);
  // From a vertex, along edges, to vertices.
  geodesics.begin_at(at(charted, {0, 0}), 100);
  for (const Vector2d& way : {Vector2d(40, 0), Vector2d(-30, 30), Vector2d(17, -33)})
    EXPECT_NEAR(geodesics.to(at(charted, way))->length, way.norm(), 1e-6);
}

// The length of the line through the points of a path that starts at `from`.
double traced(const PathMesh& mesh, const Geodesics& geodesics, int from, int to) {
  double mm = 0;
  Vector3d last = mesh.place(from);
  const std::vector<PathPoint> path = geodesics.trace(to);
  EXPECT_TRUE(!path.empty() && path.back().a == to && path.back().b == to);
  for (const PathPoint& p : path) {
    const Vector3d at = mesh.place(p.a) + p.f * (mesh.place(p.b) - mesh.place(p.a));
    mm += (at - last).norm();
    last = at;
  }
  return mm;
}

// The unit cube, two triangles per face: the path from a corner to the opposite one is the diagonal of two unfolded
// faces.
TEST(ExactGeodesics, OverACubeAreThoseOfItsUnfolding) {
  std::vector<Vector3d> places;
  for (int i = 0; i < 8; ++i) places.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c, d] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    triangles.insert(triangles.end(), {Triangle{a, b, c}, Triangle{a, c, d}});
  const PathMesh mesh(triangles, places);
  Geodesics geodesics(mesh);
  geodesics.begin_at(vertex(triangles, 0), 10);
  EXPECT_NEAR(geodesics.to(vertex(triangles, 7))->length, std::sqrt(5), 1e-6);
  EXPECT_NEAR(geodesics.to(vertex(triangles, 3))->length, std::sqrt(2), 1e-6);
  EXPECT_NEAR(geodesics.to({2, Vector3d(0.5, 0, 0.5)})->length, std::sqrt(2.5),
              1e-6);  // the middle of the far face
  EXPECT_NEAR(traced(mesh, geodesics, 0, 7), std::sqrt(5), 1e-6);
}

// A flat L of three squares: paths bend around its inner corner.
TEST(ExactGeodesics, BendAtAnInnerCorner) {
  const std::vector<Vector3d> places{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                                     {1, 1, 0}, {2, 1, 0}, {0, 2, 0}, {1, 2, 0}};
  const std::vector<Triangle> triangles{{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {3, 4, 7}, {3, 7, 6}};
  const PathMesh mesh(triangles, places);
  Geodesics geodesics(mesh);
  geodesics.begin_at({2, Vector3d(0, 0.5, 0.5)}, 10);  // (2, 0.5)
  const auto path = geodesics.to({4, Vector3d(0, 0, 1)});
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length, std::sqrt(1.25) + 1, 1e-6);
  EXPECT_LT((path->start - Vector3d(-1, 0.5, 0).normalized()).norm(), 1e-6);
}

TEST(ExactGeodesics, AreTracedAsLongAsTheyAre) {
  // A flat sheet: straight over edges, along edges and through vertices.
  const Sample flat = hand_made::flat(100, 10);
  const InkedSurface sheet = hand_made::inked(flat.sheet);
  Geodesics on_sheet(sheet.path_mesh());
  constexpr int middle = 60;  // of 11 x 11 vertices 10 mm apart
  on_sheet.begin_at(vertex(sheet.triangles(), middle), 100);
  for (const auto& [to, mm] : {std::pair{64, 40.0},
                               {120, 50 * M_SQRT2},
                               {84, std::hypot(20, 20)},
                               {74, std::hypot(30, 10)},
                               {12, std::hypot(40, 40)},
                               {3, std::hypot(20, 50)}})
    EXPECT_NEAR(traced(sheet.path_mesh(), on_sheet, middle, to), mm, 1e-9) << to;

  // The L of three squares, around its inner corner.
  const PathMesh corner(
      {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {3, 4, 7}, {3, 7, 6}},
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}, {0, 2, 0}, {1, 2, 0}});
  Geodesics around(corner);
  around.begin_at(vertex(corner.triangles(), 2), 10);
  EXPECT_NEAR(traced(corner, around, 2, 7), M_SQRT2 + 1, 1e-9);
  EXPECT_NEAR(traced(corner, around, 2, 6), 2 * M_SQRT2, 1e-9);
  around.begin_at(vertex(corner.triangles(), 2), 1);
  EXPECT_TRUE(around.trace(7).empty());

  // Bumps, where paths bend at saddles.
  const InkedSurface bumps = hand_made::inked(hand_made::bumpy_sphere(70, 110, 55, 1.5).sheet);
  Geodesics over(bumps.path_mesh());
  const int from = 28 * 56 + 28;
  over.begin_at(vertex(bumps.triangles(), from), 90);
  for (int to = 5; to < 56 * 56; to += 391)
    EXPECT_NEAR(traced(bumps.path_mesh(), over, from, to), over.to(vertex(bumps.triangles(), to))->length,
                1e-6);
}

// The trees of two sources share only the length of the path between them.
TEST(ExactGeodesics, AreAsLongThereAsBackAlsoOverBumps) {
  const Sample x = hand_made::bumpy_sphere(70, 110, 55, 1.5);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  Geodesics there(surface.path_mesh()), back(surface.path_mesh());
  const std::vector<Vector2d> ends{{3, 4}, {-31, 8}, {0, 26}, {22, -17}, {-9, -30}};
  for (const Vector2d& a : ends) {
    there.begin_at(at(charted, a), 90);
    for (const Vector2d& b : ends) {
      back.begin_at(at(charted, b), 90);
      const auto way = there.to(at(charted, b)), home = back.to(at(charted, a));
      ASSERT_TRUE(way && home);
      EXPECT_NEAR(way->length, home->length, 1e-6);
      EXPECT_GE(way->length, (surface.place(at(charted, a)) - surface.place(at(charted, b))).norm() - 1e-9);
      const Connection shot = connect(surface, at(charted, a), at(charted, b));
      if (shot.found && a != b) {
        EXPECT_LE(way->length, shot.mm + 1e-5);
      }
    }
  }
}

TEST(ExactGeodesics, AreAsLongToOneTargetAsToAll) {
  const Sample x = hand_made::bumpy_sphere(70, 110, 55, 1.5);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  Geodesics all(surface.path_mesh()), one(surface.path_mesh());
  const std::vector<Vector2d> ends{{3, 4}, {-31, 8}, {0, 26}, {22, -17}, {-9, -30}, {3.5, 4.2}};
  for (const Vector2d& a : ends) {
    all.begin_at(at(charted, a), 90);
    for (const Vector2d& b : ends) {
      const auto way = all.to(at(charted, b));
      ASSERT_TRUE(way);
      for (const double reach : {90.0, 1.02 * way->length + 0.1, way->length + 1e-6}) {
        one.begin_at(at(charted, a), at(charted, b), reach);
        const auto found = one.to(at(charted, b));
        ASSERT_TRUE(found) << reach;
        EXPECT_NEAR(found->length, way->length, 1e-9);
        EXPECT_LT((found->start - way->start).norm(), 1e-6);
      }
      if (way->length == 0) continue;
      one.begin_at(at(charted, a), at(charted, b), 0.99 * way->length);
      EXPECT_FALSE(one.to(at(charted, b)));
    }
  }
}

TEST(ElementPatch, OnBumpsHasCirclesThatAreRoundByExactGeodesics) {
  const Sample x = hand_made::bumpy_sphere(70, 110, 55, 1.5);
  const hand_made::Charted charted(x);
  const InkedSurface& surface = charted.surface;
  const SheetPoint centre = at(charted, {3, 4});
  const auto patch =
      element_patch(charted, centre, charted.charted.axis(centre.triangle), 18, CoilKeep::area, Context());
  ASSERT_TRUE(patch);
  EXPECT_FALSE(patch->smooth);
  Geodesics geodesics(surface.path_mesh());
  geodesics.begin_at(centre, 40);
  const PlaneLocator flat(patch->patch.triangles, patch->patch.uv);
  double least = 1e9, most = 0;
  for (int i = 0; i < 360; ++i) {
    const auto on_patch = flat.find(15 * Vector2d(std::cos(i * M_PI / 180), std::sin(i * M_PI / 180)));
    ASSERT_TRUE(on_patch);
    const auto path =
        geodesics.to(at(charted, interpolate(patch->patch.triangles, *on_patch, patch->patch.rest)));
    ASSERT_TRUE(path);
    least = std::min(least, path->length), most = std::max(most, path->length);
  }
  EXPECT_LT((most - least) / (most + least), 0.004);  // about half of that is circularity
}

}  // namespace
}  // namespace vacuform
