#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "tests/unit/worker/flattening/flattening_charts.hpp"
#include "worker/numerics/plane.hpp"

namespace vacuform {
namespace {

Result<Flattening> flat(const FormedSheet& sheet, const Eigen::Vector3d& top,
                        FlatteningMethod method = FlatteningMethod::arap, InkedFace face = InkedFace::inner) {
  FlatteningSettings settings;
  settings.method = method;
  return flatten(sheet, inked_surface(sheet, face), top_at(top), settings, Context{});
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

// A block with vertical walls, all of it on the mold, off centre and turned. Seen from above the walls have no area, but
// for rounding.
FormedSheet block_sheet(double yaw_deg, double spacing = 2) {
  constexpr double half = 20, height = 15, x = 7, y = -3;
  const Eigen::Rotation2Dd turn(yaw_deg * std::numbers::pi / 180);
  return sheet_of(20, spacing, [&](double s, double t) {
    const double down = std::max({0.0, std::abs(s) - half, std::abs(t) - half});
    const Eigen::Vector2d at =
        turn * Eigen::Vector2d(x + std::clamp(s, -half, half), y + std::clamp(t, -half, half));
    return Eigen::Vector3d(at.x(), at.y(), height - down);
  });
}

// The place in space, on the formed face, of a point of the chart.
Eigen::Vector3d place_at(const FormedSheet& sheet, const Flattening& f, const Eigen::Vector2d& chart) {
  for (const int k : f.triangles) {
    const Triangle& t = sheet.triangles[k];
    const Eigen::Vector2d &a = f.chart[t[0]], &b = f.chart[t[1]], &c = f.chart[t[2]];
    const Eigen::Vector3d w(cross(b - chart, c - chart), cross(c - chart, a - chart),
                            cross(a - chart, b - chart));
    if (w.minCoeff() >= -1e-9 * w.sum() && w.sum() > 0)
      return (w[0] * sheet.formed[t[0]] + w[1] * sheet.formed[t[1]] + w[2] * sheet.formed[t[2]]) / w.sum();
  }
  return Eigen::Vector3d::Constant(NAN);
}

TEST(Flattening, FindsTheTopOnItsVerticalBesideVerticalWalls) {
  for (int yaw = 0; yaw <= 90; yaw += 5) {
    const FormedSheet sheet = block_sheet(yaw);
    const Eigen::Rotation2Dd turn(yaw * std::numbers::pi / 180);
    // The middle of the upper face, the middle of an edge, a corner, and a place on another edge.
    for (const Eigen::Vector2d& on : {Eigen::Vector2d(7, -3), Eigen::Vector2d(27, -3),
                                      Eigen::Vector2d(27, 17), Eigen::Vector2d(9.3, -23)}) {
      const Eigen::Vector2d at = turn * on;
      const auto f = flat(sheet, {at.x(), at.y(), 15});
      ASSERT_TRUE(f) << f.error().text();
      EXPECT_TRUE(f->warnings.empty() || f->warnings[0].code != "top-off-chart");
      const Eigen::Vector3d found = place_at(sheet, *f, {0, 0});
      EXPECT_LT((found - Eigen::Vector3d(at.x(), at.y(), 15)).norm(), 1e-4) << yaw << ": " << on.transpose();
    }
  }
}

TEST(Flattening, OuterFaceIsAThicknessFurtherOut) {
  const auto sheet = dome(60);
  const auto outer = flat(sheet, {0, 0, 60}, FlatteningMethod::arap, InkedFace::outer);
  ASSERT_TRUE(outer);
  const auto inner_face = inked_positions(sheet, InkedFace::inner),
             outer_face = inked_positions(sheet, InkedFace::outer);
  for (const int k : outer->triangles)
    for (int v : sheet.triangles[k]) {
      EXPECT_NEAR(inner_face[v].norm(), 60, 1e-9);
      EXPECT_NEAR(outer_face[v].norm(), 61, 0.01);
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

// The largest distance between two flattenings of the same chart.
double apart(const FormedSheet& sheet, const Flattening& a, const Flattening& b) {
  double furthest = 0;
  for (const int k : a.triangles)
    for (const int v : sheet.triangles[k]) furthest = std::max(furthest, (a.chart[v] - b.chart[v]).norm());
  return furthest;
}

// Where a point of the flat sheet, which must be one of its vertices, lies on the chart.
Eigen::Vector2d at_rest(const FormedSheet& sheet, const Flattening& f, double s, double t) {
  for (std::size_t i = 0; i < sheet.rest.size(); ++i)
    if ((sheet.rest[i] - Eigen::Vector2d(s, t)).norm() < 1e-9) return f.chart[i];
  throw std::logic_error("no such vertex");
}

TEST(Flattening, EveryMethodIsLaidTheSameWay) {
  const auto sheet = sheet_of(16, 2, [](double s, double t) {
    return Eigen::Vector3d(40 * std::sin(s / 40), t, 40 * std::cos(s / 40));
  });
  const auto expected = flat(sheet, {0, 0, 40});
  ASSERT_TRUE(expected);
  for (const auto method : {FlatteningMethod::symmetric_dirichlet, FlatteningMethod::lscm,
                            FlatteningMethod::cgal_arap, FlatteningMethod::bfs}) {
    const auto f = flat(sheet, {0, 0, 40}, method);
    ASSERT_TRUE(f) << f.error().text();
    EXPECT_LT(apart(sheet, *expected, *f), 0.01);
    EXPECT_TRUE(f->warnings.empty());
  }
}

TEST(Flattening, WarnsWhereAMethodTurnsTrianglesOver) {
  const auto sheet = sheet_of(16, 2, [](double s, double t) {
    return Eigen::Vector3d(s, t, 30 + 8 * std::sin(0.4 * s) * std::cos(0.3 * t));
  });
  const auto f = flat(sheet, {0, 0, 30}, FlatteningMethod::bfs);
  ASSERT_TRUE(f);
  EXPECT_GT(f->flipped, 0);
  EXPECT_TRUE(std::isinf(f->symmetric_dirichlet));
  ASSERT_FALSE(f->warnings.empty());
  EXPECT_EQ(f->warnings[0].code, "flattening-flipped");
  const auto d = flat(sheet, {0, 0, 30}, FlatteningMethod::symmetric_dirichlet);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->flipped, 0);
  EXPECT_EQ(d->crossings, 0);
  EXPECT_TRUE(d->warnings.empty());
  EXPECT_LT(d->symmetric_dirichlet, 6);
}

TEST(Flattening, OnePinOnlyShifts) {
  const auto sheet = dome(60);
  const auto free = flat(sheet, {0, 0, 60});
  FlatteningSettings settings;
  settings.pins = {{10, -8, 30, 40}};
  for (const auto method : {FlatteningMethod::arap, FlatteningMethod::bfs}) {
    settings.method = method;
    const auto unpinned = flat(sheet, {0, 0, 60}, method);
    const auto f =
        flatten(sheet, inked_surface(sheet, InkedFace::inner), top_at({0, 0, 60}), settings, Context{});
    ASSERT_TRUE(f && unpinned);
    EXPECT_LT((at_rest(sheet, *f, 10, -8) - Eigen::Vector2d(30, 40)).norm(), 1e-9);
    const Eigen::Vector2d shift = Eigen::Vector2d(30, 40) - at_rest(sheet, *unpinned, 10, -8);
    for (const int k : f->triangles)
      for (const int v : sheet.triangles[k])
        EXPECT_LT((f->chart[v] - unpinned->chart[v] - shift).norm(), 1e-9);
    EXPECT_NEAR(f->energy, unpinned->energy, 1e-12);
  }
}

// Two pins at the distance that the free chart gives them turn it and distort nothing; further apart, they are met at the
// cost of distortion by the methods that bend, and missed, with a warning, by those that do not.
TEST(Flattening, TwoPinsTurnAndBend) {
  const auto sheet = dome(60);
  const auto free = flat(sheet, {0, 0, 60});
  ASSERT_TRUE(free);
  const Eigen::Rotation2Dd turn(0.5);
  const Eigen::Vector2d a = turn * at_rest(sheet, *free, -20, 4), b = turn * at_rest(sheet, *free, 24, -6);
  const auto pinned = [&](FlatteningMethod method, double stretch) {
    FlatteningSettings settings;
    settings.method = method;
    settings.pins = {{-20, 4, stretch * a.x(), stretch * a.y()}, {24, -6, stretch * b.x(), stretch * b.y()}};
    return *flatten(sheet, inked_surface(sheet, InkedFace::inner), top_at({0, 0, 60}), settings, Context{});
  };
  const Flattening turned = pinned(FlatteningMethod::arap, 1);
  EXPECT_NEAR(turned.energy, free->energy, 1e-4 * free->energy);
  for (const int k : turned.triangles)
    for (const int v : sheet.triangles[k]) EXPECT_LT((turned.chart[v] - turn * free->chart[v]).norm(), 0.05);
  for (const auto method : {FlatteningMethod::arap, FlatteningMethod::symmetric_dirichlet}) {
    const Flattening bent = pinned(method, 1.1);
    EXPECT_LT((at_rest(sheet, bent, -20, 4) - 1.1 * a).norm(), 1e-3);
    EXPECT_LT((at_rest(sheet, bent, 24, -6) - 1.1 * b).norm(), 1e-3);
    EXPECT_GT(bent.energy, 1.001 * free->energy);
    EXPECT_TRUE(bent.warnings.empty());
  }
  const Flattening missed = pinned(FlatteningMethod::cgal_arap, 1.1);
  ASSERT_EQ(missed.warnings.size(), 1u);
  EXPECT_EQ(missed.warnings[0].code, "pins-not-met");
  const double miss = (at_rest(sheet, missed, 24, -6) - 1.1 * b).norm();
  EXPECT_NEAR(miss, 0.05 * (a - b).norm(), 0.2);  // half of what is missing at either end
}

TEST(Flattening, APinOffTheChartIsRefusedByItsNumber) {
  FlatteningSettings settings;
  settings.pins = {{0, 0, 0, 0}, {47, 0, 60, 0}};
  const auto f =
      flatten(dome(60), inked_surface(dome(60), InkedFace::inner), top_at({0, 0, 60}), settings, Context{});
  ASSERT_FALSE(f);
  EXPECT_EQ(f.error().code, Code::bad_settings);
  EXPECT_EQ(f.error().text(),
            "the sheet's point of pin 2 is not on the chart (flattening.pins); choose points of the sheet "
            "that come to "
            "lie on the mold");
}

// A weight of 10 where a ring of ink lies cuts the energy there by more than four, for little more elsewhere.
TEST(Flattening, InkIsSparedWhereItLies) {
  const auto sheet = dome(60, 36, 1.4);
  const InkCoverage ring = [](const Eigen::Vector2d& p, double) {
    return std::abs(p.norm() - 35) < 2.5 ? 1.0 : 0.0;
  };
  FlatteningSettings settings;
  settings.weights = FlatteningWeights::ink;
  for (const auto method : {FlatteningMethod::arap, FlatteningMethod::symmetric_dirichlet}) {
    settings.method = method;
    const auto even = flat(sheet, {0, 0, 60}, method);
    const auto f =
        flatten(sheet, inked_surface(sheet, InkedFace::inner), top_at({0, 0, 60}), settings, Context{}, ring);
    ASSERT_TRUE(even && f);
    ASSERT_EQ(f->favoured.size(), f->triangles.size());
    ASSERT_EQ(f->weight.size(), f->triangles.size());
    Chart before{{}, sheet.formed, even->chart};
    for (std::size_t k = 0; k < f->triangles.size(); ++k) {
      const Triangle& t = sheet.triangles[f->triangles[k]];
      const Eigen::Vector2d middle = (f->chart[t[0]] + f->chart[t[1]] + f->chart[t[2]]) / 3;
      if (std::abs(middle.norm() - 35) < 1.5) {
        EXPECT_EQ(f->favoured[k], 1);  // the ink is where the weights are: the rounds have settled
      }
      if (f->favoured[k]) before.triangles.push_back(t);
    }
    EXPECT_LT(4 * f->energy_favoured, chart_quality(before).arap);
    EXPECT_LT(f->energy, 1.3 * even->energy);
    EXPECT_GT(f->energy_rest, f->energy);
  }
}

// A picture that darkens from left to right: every triangle counts by how dark it is where it lies, and the dark half is
// distorted less than it was.
TEST(Flattening, PaintWeighsByItsDarkness) {
  const auto sheet = dome(60);
  const InkCoverage paint = [](const Eigen::Vector2d& p, double) {
    return std::clamp(0.5 + p.x() / 60, 0.0, 1.0);
  };
  FlatteningSettings settings;
  settings.weights = FlatteningWeights::painted;
  settings.weight = 20;
  const auto even = flat(sheet, {0, 0, 60});
  const auto f =
      flatten(sheet, inked_surface(sheet, InkedFace::inner), top_at({0, 0, 60}), settings, Context{}, paint);
  ASSERT_TRUE(even && f);
  ASSERT_EQ(f->weight.size(), f->triangles.size());
  Chart before{{}, sheet.formed, even->chart};
  for (std::size_t k = 0; k < f->triangles.size(); ++k) {
    const Triangle& t = sheet.triangles[f->triangles[k]];
    const Eigen::Vector2d middle = (f->chart[t[0]] + f->chart[t[1]] + f->chart[t[2]]) / 3;
    EXPECT_NEAR(f->weight[k], 1 + 19 * paint(middle, 0), 0.5);  // the rounds have settled
    if (f->favoured[k]) before.triangles.push_back(t);
  }
  EXPECT_LT(2 * f->energy_favoured, chart_quality(before).arap);
}

TEST(Flattening, InkAndPaintMustBeGivenWhereTheyCount) {
  FlatteningSettings settings;
  for (const auto weights : {FlatteningWeights::ink, FlatteningWeights::painted}) {
    settings.weights = weights;
    EXPECT_THROW((void)flatten(dome(60), inked_surface(dome(60), InkedFace::inner), top_at({0, 0, 60}),
                               settings, Context{}),
                 std::invalid_argument);
  }
}

TEST(Flattening, CenterSparesTheTop) {
  const auto sheet = dome(60);
  const auto even = flat(sheet, {0, 0, 60});
  FlatteningSettings settings;
  settings.weights = FlatteningWeights::center;
  settings.weight = 50;
  const auto f =
      flatten(sheet, inked_surface(sheet, InkedFace::inner), top_at({0, 0, 60}), settings, Context{});
  ASSERT_TRUE(even && f);
  Chart before{{}, sheet.formed, even->chart};
  for (std::size_t k = 0; k < f->triangles.size(); ++k) {
    const Triangle& t = sheet.triangles[f->triangles[k]];
    const double r = std::max({sheet.rest[t[0]].norm(), sheet.rest[t[1]].norm(), sheet.rest[t[2]].norm()});
    if (r < 3) {
      EXPECT_GT(f->weight[k], 49);
    }
    if (f->favoured[k]) before.triangles.push_back(t);
    EXPECT_GE(f->weight[k], 1);
    EXPECT_LE(f->weight[k], 50);
  }
  EXPECT_LT(4 * f->energy_favoured, chart_quality(before).arap);
}

TEST(Weights, CenterIsOneAtTheRimAndSmoothBetween) {
  const Chart chart = grid_chart(40, 40, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  const auto weights = center_weights(chart, 2 * (20 * 40 + 20), {1, 0, 0}, 11);  // the point (20, 20)
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const Triangle& t = chart.triangles[k];
    double x = 0, rim = 0, top = 0;
    for (const int v : t) {
      const Eigen::Vector3d& p = chart.inked[v];
      rim += std::min({p.x(), p.y(), 40 - p.x(), 40 - p.y()}) / 3;
      top += (p - Eigen::Vector3d(20, 20, 0)).norm() / 3;
    }
    x = rim / (rim + top);
    EXPECT_NEAR(weights[k], 1 + 10 * x * x * (3 - 2 * x), 0.15);
  }
  EXPECT_NEAR(*std::max_element(weights.begin(), weights.end()), 11, 0.2);
}

TEST(Weights, DistancesAreGeodesic) {
  const Chart sphere = cap(2.0, 30);
  std::vector<double> start(sphere.uv.size(), std::numeric_limits<double>::infinity());
  start[0] = 0;
  const auto distance = surface_distance(sphere, start);
  for (std::size_t v = 1; v < distance.size(); ++v) {
    const double polar = std::acos(std::clamp(sphere.inked[v].z(), -1.0, 1.0));
    EXPECT_NEAR(distance[v], polar, 0.02 * polar);
  }
}

TEST(Weights, InkOfAQuarterCountsInFull) {
  const Chart chart = grid_chart(20, 1, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  const auto weights = ink_weights(
      chart,
      [](const Eigen::Vector2d& p, double blur) { return blur > 0.7 && blur < 0.71 ? p.x() / 40 : -1; }, 9);
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const Triangle& t = chart.triangles[k];
    const double x = (chart.uv[t[0]] + chart.uv[t[1]] + chart.uv[t[2]]).x() / 3;
    EXPECT_NEAR(weights[k], std::min(9.0, 1 + 8 * x / 10), 1e-12);
  }
}

}  // namespace
}  // namespace vacuform
