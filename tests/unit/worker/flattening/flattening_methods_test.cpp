// The methods of flattening on charts of known answer, and on charts that are hard.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <random>

#include "tests/unit/worker/flattening/flattening_charts.hpp"
#include "worker/flattening/embedding.hpp"
#include "worker/flattening/methods.hpp"

namespace vacuform {
namespace {

using Method = std::function<Result<FlatteningOutcome>(Chart&, const Context&)>;
struct Named {
  const char* name;
  Method flatten;
};
const Named arap{"arap", [](Chart& c, const Context& x) { return flatten_arap(c, x); }};
const Named hybrid{"arap, lambda 1", [](Chart& c, const Context& x) { return flatten_arap(c, x, 1.0); }};
const Named dirichlet{"symmetric_dirichlet", flatten_symmetric_dirichlet};
const Named lscm{"lscm", flatten_lscm};
const Named bfs{"bfs", [](Chart& c, const Context& x) { return flatten_breadth_first(c, 0, x); }};
const Named cgal{"cgal_arap", [](Chart& c, const Context& x) { return flatten_cgal_arap(c, x); }};

Chart cylinder(int columns = 24, int rows = 16) {
  return grid_chart(columns, rows, [](double x, double y) {
    return Eigen::Vector3d(20 * std::sin(1.5 * x / 20), 0.8 * y, 20 * std::cos(1.5 * x / 20));
  });
}

Chart bumps() {
  return grid_chart(30, 30, [](double x, double y) {
    return Eigen::Vector3d(x, y, 3 * std::sin(0.35 * x) * std::cos(0.3 * y) + 0.05 * x * y / 10);
  });
}

// Whatever the grid was stretched by, a developable surface is laid flat without distortion.
TEST(Methods, ACylinderHasNoDistortion) {
  for (const Named& method : {arap, hybrid, dirichlet, lscm, bfs, cgal}) {
    Chart chart = cylinder();
    const auto outcome = method.flatten(chart, Context{});
    ASSERT_TRUE(outcome) << method.name << outcome.error().text();
    EXPECT_TRUE(outcome->converged) << method.name;
    const ChartQuality quality = chart_quality(chart);
    EXPECT_LT(quality.arap, 1e-6) << method.name;
    EXPECT_LT(quality.symmetric_dirichlet, 4 + 4e-6) << method.name;
    EXPECT_EQ(quality.flipped, 0) << method.name;
  }
}

// A shallow cap of polar angle q is a flat disk with the Gaussian curvature of a sphere: its residual strain stores
// Y pi K^2 a^6 / 384 (plate theory, Poisson's ratio 0, Y = 2 for the energy |strain|^2), q^4 / 192 an area. The symmetric
// Dirichlet energy is four times as stiff.
TEST(Methods, AShallowCapHasTheEnergyOfPlateTheory) {
  const double polar = 0.3, expected = std::pow(polar, 4) / 192;
  Chart a = cap(polar, 20), d = a;
  ASSERT_TRUE(flatten_arap(a, Context{}) && flatten_symmetric_dirichlet(d, Context{}));
  EXPECT_NEAR(chart_quality(a).arap, expected, 0.03 * expected);
  EXPECT_NEAR(chart_quality(d).symmetric_dirichlet - 4, 4 * expected, 0.12 * expected);
}

// The conformal maps of a sphere: no method keeps angles better, and every other pays less in areas.
TEST(Methods, LscmKeepsTheAnglesOfAHemisphere) {
  const auto angles_and_areas = [](const Chart& chart) {
    double stretch = 0, area = 0, total = 0;
    const auto all = elements(chart);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Eigen::Matrix2d J = jacobian(chart, all, k);
      const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
      stretch += all[k].area * (J.squaredNorm() / (2 * det) - 1);
      area += all[k].area * std::abs(std::log(det));
      total += all[k].area;
    }
    return std::pair{stretch / total, area / total};
  };
  Chart conformal = cap(std::numbers::pi / 2, 24), rigid = conformal;
  ASSERT_TRUE(flatten_lscm(conformal, Context{}) && flatten_arap(rigid, Context{}));
  const auto [shape_c, area_c] = angles_and_areas(conformal);
  const auto [shape_r, area_r] = angles_and_areas(rigid);
  EXPECT_LT(shape_c, 1e-3);
  EXPECT_GT(shape_r, 10 * shape_c);
  EXPECT_GT(area_c, 2 * area_r);
  // Stereographic: the rim's scale is twice the middle's, and the area is the hemisphere's.
  double inner = 0, outer = 0;
  for (std::size_t i = 1; i <= 6; ++i) inner += (conformal.uv[i] - conformal.uv[0]).norm() / 6;
  for (std::size_t i = conformal.uv.size() - 144; i < conformal.uv.size(); ++i)
    outer += (conformal.uv[i] - conformal.uv[0]).norm() / 144;
  EXPECT_NEAR(outer / inner, 1 / std::tan(std::numbers::pi / 96), 0.05 / std::tan(std::numbers::pi / 96));
  EXPECT_NEAR(outer, std::sqrt(2), 0.02);
}

// With lambda the chart goes from conformal to as rigid as possible.
TEST(Methods, LambdaTradesAnglesAgainstAreas) {
  double before = 1e9;
  for (const double lambda : {0.03, 0.3, 3.0, 1e4}) {
    Chart chart = cap(1.2, 12);
    ASSERT_TRUE(flatten_arap(chart, Context{}, lambda));
    double area = 0;
    const auto all = elements(chart);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Eigen::Matrix2d J = jacobian(chart, all, k);
      area += all[k].area * std::abs(std::log(J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0)));
    }
    EXPECT_LT(area, before) << lambda;
    before = area;
  }
  Chart rigid = cap(1.2, 12), limit = rigid;
  ASSERT_TRUE(flatten_arap(rigid, Context{}) && flatten_arap(limit, Context{}, 1e6));
  for (std::size_t i = 0; i < rigid.uv.size(); ++i) EXPECT_LT((rigid.uv[i] - limit.uv[i]).norm(), 1e-3);
}

// Each of the two minimizes its own energy, and CGAL's ARAP no lower than ours.
TEST(Methods, EachMinimizesItsOwn) {
  Chart a = bumps(), d = a, c = a;
  ASSERT_TRUE(flatten_arap(a, Context{}) && flatten_symmetric_dirichlet(d, Context{}) &&
              flatten_cgal_arap(c, Context{}));
  const ChartQuality qa = chart_quality(a), qd = chart_quality(d), qc = chart_quality(c);
  EXPECT_LT(qa.arap, qd.arap);
  EXPECT_LT(qd.symmetric_dirichlet, qa.symmetric_dirichlet);
  EXPECT_LT(qa.arap, 1.001 * qc.arap);
}

TEST(Methods, UnfoldingBreadthFirstPilesUpErrors) {
  Chart good = bumps(), bad = good;
  ASSERT_TRUE(flatten_arap(good, Context{}) && flatten_breadth_first(bad, 900, Context{}));
  EXPECT_GT(chart_quality(bad).arap, 10 * chart_quality(good).arap);
}

// Follows a flattening step by step: no triangle is turned over from the start to the end.
void expect_no_flips(Chart chart, const std::string& name) {
  int seen = 0;
  const Context context([&](Stage, double) {
    ++seen;
    if (seen > 1) {
      EXPECT_EQ(chart_quality(chart).flipped, 0) << name;
    }
  });
  const auto outcome = flatten_symmetric_dirichlet(chart, context);
  ASSERT_TRUE(outcome) << name << outcome.error().text();
  EXPECT_TRUE(outcome->converged) << name;
  const ChartQuality quality = chart_quality(chart);
  EXPECT_EQ(quality.flipped, 0) << name;
  EXPECT_TRUE(std::isfinite(quality.symmetric_dirichlet)) << name;
  EXPECT_GT(seen, 2) << name;
}

TEST(SymmetricDirichletMethod, NoFlipsOnNastyCharts) {
  expect_no_flips(bumps(), "bumps");
  // Slivers of 0.7 degrees: every second column is a hundredth as wide, on the surface only or on both sides.
  const auto squeezed = [](double x) {
    return std::floor(x / 2) * 1.012 + (std::fmod(x, 2) > 0 ? 1.0 : 0.0);
  };
  Chart slivers = grid_chart(20, 20, [&](double x, double y) {
    return Eigen::Vector3d(squeezed(x), y, 2 * std::sin(0.4 * x + 0.3 * y));
  });
  expect_no_flips(slivers, "slivers on the surface");
  for (auto& p : slivers.uv) p.x() = squeezed(p.x());
  expect_no_flips(slivers, "slivers on both");
  // A rough surface, whose ARAP chart has triangles turned over.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  Chart rough = grid_chart(16, 16, [&](double x, double y) {
    return Eigen::Vector3d(x + 0.8 * any(random), y + 0.8 * any(random), 4 * any(random));
  });
  Chart by_arap = rough;
  ASSERT_TRUE(flatten_arap(by_arap, Context{}));
  EXPECT_GT(chart_quality(by_arap).flipped, 0);  // or this is no hard case
  expect_no_flips(rough, "rough");
  // A start that is folded over, and one without any sense.
  Chart folded = bumps();
  for (auto& p : folded.uv) p.x() = std::abs(p.x() - 12);
  expect_no_flips(folded, "folded");
  for (auto& p : folded.uv) p = {any(random), any(random)};
  expect_no_flips(folded, "random");
  // Points that coincide on the surface: triangles without area.
  Chart flat = bumps();
  flat.inked[200] = flat.inked[201];
  flat.inked[400] = flat.inked[401] = flat.inked[432];
  expect_no_flips(flat, "without area");
}

TEST(SymmetricDirichletMethod, AChartThatIsNoDiskAndFoldedIsRefused) {
  Chart chart = bumps();
  chart.triangles.erase(chart.triangles.begin() + 400, chart.triangles.begin() + 402);
  expect_no_flips(chart, "with a hole");
  for (auto& p : chart.uv) p.x() = std::abs(p.x() - 12);
  const auto refused = flatten_symmetric_dirichlet(chart, Context{});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::unusable_surface);
}

// A ramp that winds 400 degrees around a post develops onto itself. LSCM lays it there; symmetric_dirichlet stops where its
// ends touch, and pays little for it.
TEST(SymmetricDirichletMethod, ARampThatWouldCoverItselfDoesNot) {
  Chart ramp = grid_chart(60, 5, [](double x, double y) {
    const double angle = 7 * x / 60, r = 10 + y;
    return Eigen::Vector3d(-r * std::cos(angle), r * std::sin(angle), 0.8 * angle);
  });
  Chart conformal = ramp;
  ASSERT_TRUE(flatten_lscm(conformal, Context{}));
  EXPECT_GT(border_crossings(conformal), 0);  // or this is no hard case
  double last = 0;
  const Context context([&](Stage, double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  const auto outcome = flatten_symmetric_dirichlet(ramp, context);
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(outcome->converged);
  const ChartQuality quality = chart_quality(ramp);
  EXPECT_EQ(quality.flipped, 0);
  EXPECT_EQ(border_crossings(ramp), 0);
  EXPECT_LT(quality.symmetric_dirichlet, 4.01);
}

// Weights of 1, 10 and 1000 on half of the chart: the energy there falls with each, and nothing turns over.
TEST(Methods, WeightsMoveTheDistortionAway) {
  for (const Named& method : {arap, dirichlet}) {
    double before = 1e9;
    for (const double weight : {1.0, 10.0, 1000.0}) {
      Chart chart = cap(1.1, 16);
      for (const Triangle& t : chart.triangles)
        chart.weight.push_back(chart.inked[t[0]].x() > 0 ? weight : 1);
      ASSERT_TRUE(method.flatten(chart, Context{}));
      Chart part{{}, chart.inked, chart.uv};
      for (const Triangle& t : chart.triangles)
        if (chart.inked[t[0]].x() > 0) part.triangles.push_back(t);
      const double now = chart_quality(part).arap;
      EXPECT_LT(now, 0.8 * before) << method.name << weight;
      EXPECT_EQ(chart_quality(chart).flipped, 0);
      before = now;
    }
  }
}

// Pins 20 % further apart than the surface has them: each method that knows them meets them.
TEST(Methods, PinsAreMet) {
  for (const Named& method : {arap, dirichlet, lscm}) {
    Chart chart = cap(1.0, 12);
    for (const int k : {20, 200, 250}) {
      const Triangle& t = chart.triangles[k];
      const Eigen::Vector3d corners(0.2, 0.5, 0.3);
      const Eigen::Vector3d p = 0.2 * chart.inked[t[0]] + 0.5 * chart.inked[t[1]] + 0.3 * chart.inked[t[2]];
      chart.pins.push_back(
          {k, corners, Eigen::Vector2d(5, 3) + Eigen::Rotation2Dd(0.4) * Eigen::Vector2d(1.2 * p.head<2>())});
    }
    ASSERT_TRUE(method.flatten(chart, Context{}));
    for (const ChartPin& pin : chart.pins) {
      const Triangle& t = chart.triangles[pin.triangle];
      const Eigen::Vector2d place = 0.2 * chart.uv[t[0]] + 0.5 * chart.uv[t[1]] + 0.3 * chart.uv[t[2]];
      EXPECT_LT((place - pin.target).norm(), 1e-3) << method.name;
    }
    EXPECT_EQ(chart_quality(chart).flipped, 0) << method.name;
  }
}

// A surface twice as large, turned in space, with its triangles in another order: the same chart, twice as large.
TEST(Methods, NeitherScaleNorTurnNorOrderMatters) {
  const Eigen::AngleAxisd turn(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  for (const Named& method : {arap, hybrid, dirichlet, lscm, cgal}) {
    Chart one = cap(1.2, 8), other = one;
    for (auto& p : other.inked) p = 2 * (turn * p) + Eigen::Vector3d(10, 20, 30);
    for (auto& p : other.uv) p *= 2;
    std::reverse(other.triangles.begin(), other.triangles.end());
    ASSERT_TRUE(method.flatten(one, Context{}) && method.flatten(other, Context{}));
    const ChartQuality a = chart_quality(one), b = chart_quality(other);
    EXPECT_NEAR(a.arap, b.arap, 1e-4 * a.arap) << method.name;
    EXPECT_NEAR(a.symmetric_dirichlet, b.symmetric_dirichlet, 1e-5) << method.name;
  }
}

TEST(Methods, RepeatToTheLastBit) {
  for (const Named& method : {arap, hybrid, dirichlet, lscm, bfs, cgal}) {
    Chart one = cap(1.2, 8), two = one;
    ASSERT_TRUE(method.flatten(one, Context{}) && method.flatten(two, Context{}));
    EXPECT_EQ(one.uv, two.uv) << method.name;
  }
}

TEST(Methods, EndWhenCancelled) {
  for (const Named& method : {arap, dirichlet, lscm, bfs, cgal}) {
    Context context;
    context.cancel();
    Chart chart = bumps();
    const auto outcome = method.flatten(chart, context);
    ASSERT_FALSE(outcome) << method.name;
    EXPECT_EQ(outcome.error().code, Code::cancelled);
  }
  for (const Named& method : {arap, dirichlet}) {  // in the midst of it
    int steps = 0;
    Context context;
    context = Context([&](Stage, double) {
      if (++steps == 3) context.cancel();
    });
    Chart chart = bumps();
    ASSERT_FALSE(method.flatten(chart, context)) << method.name;
    EXPECT_LE(steps, 4) << method.name;
  }
}

TEST(Methods, ProgressNeverGoesBack) {
  for (const Named& method : {arap, dirichlet, lscm, bfs, cgal}) {
    double last = 0;
    const Context context([&](Stage, double fraction) {
      EXPECT_GE(fraction, last) << method.name;
      EXPECT_LE(fraction, 1) << method.name;
      last = fraction;
    });
    Chart chart = bumps();
    ASSERT_TRUE(method.flatten(chart, context));
    EXPECT_GT(last, 0.3) << method.name;
  }
}

TEST(Embedding, TuttesDiskTurnsNothingOver) {
  Chart chart = bumps();
  for (auto& p : chart.uv) p.setZero();
  ASSERT_TRUE(embed_on_disk(chart));
  EXPECT_EQ(chart_quality(chart).flipped, 0);
  EXPECT_EQ(border_crossings(chart), 0);
  chart.triangles.erase(chart.triangles.begin() + 400, chart.triangles.begin() + 402);
  EXPECT_FALSE(embed_on_disk(chart));
}

TEST(Embedding, FindsCrossings) {
  Chart chart = grid_chart(10, 2, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  EXPECT_EQ(border_crossings(chart), 0);
  // The strip wound into a ring of more than a turn: its ends lie on each other.
  for (auto& p : chart.uv) {
    const double angle = 0.7 * p.x(), r = 3 + p.y();
    p = {-r * std::cos(angle), r * std::sin(angle)};
  }
  EXPECT_EQ(chart_quality(chart).flipped, 0);
  EXPECT_GT(border_crossings(chart), 0);
}

}  // namespace
}  // namespace vacuform
