#include "worker/coils/array_relaxation.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/coils/array_starts.hpp"
#include "worker/coils/inductance.hpp"

namespace vacuform::array_relaxation_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using hand_made::Sample;

std::vector<Vector2d> flower(double apart, double noise_mm) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-noise_mm, noise_mm);
  std::vector<Vector2d> out{{0, 0}};
  for (int i = 0; i < 6; ++i)
    out.push_back(apart * Vector2d(std::cos(i * M_PI / 3 + 0.2), std::sin(i * M_PI / 3 + 0.2)));
  for (Vector2d& p : out) p += Vector2d(noise(random), noise(random));
  return out;
}

std::vector<Vector3d> circle_in_space(const Vector3d& middle, const Vector3d& u, const Vector3d& v,
                                      double radius) {
  std::vector<Vector3d> out;
  for (int i = 0; i < 200; ++i)
    out.push_back(middle + radius * (std::cos(M_PI * i / 100) * u + std::sin(M_PI * i / 100) * v));
  return out;
}

TEST(CircleCouplings, AreNeumannsForFlatAndTiltedCircles) {
  const CircleCouplings table;
  constexpr double radius = 25, trace = 3;
  const auto one = circle_in_space({0, 0, 0}, Vector3d::UnitX(), Vector3d::UnitY(), radius);
  for (const double ratio : {0.5, 0.76, 0.9, 1.2, 1.9}) {
    const auto other =
        circle_in_space({2 * radius * ratio, 0, 0}, Vector3d::UnitX(), Vector3d::UnitY(), radius);
    EXPECT_NEAR(table.at(ratio, 0, radius, trace).k, coupling(one, trace, other, trace), 0.003) << ratio;
  }
  // On a sphere: the second circle is the first, turned about its middle.
  constexpr double sphere = 85, tilt = 0.7;
  const double half = 2 * std::asin(radius / (2 * sphere)), r = sphere * std::sin(half),
               down = sphere * std::cos(half);
  const Vector3d up(std::sin(tilt), 0, std::cos(tilt)), along(std::cos(tilt), 0, -std::sin(tilt));
  const double k = coupling(circle_in_space({0, 0, down}, Vector3d::UnitX(), Vector3d::UnitY(), r), trace,
                            circle_in_space(down * up, along, Vector3d::UnitY(), r), trace);
  const double ratio = sphere * std::sin(tilt / 2) / radius;
  EXPECT_NEAR(table.at(ratio, tilt, radius, trace).k, k, 0.003);
  const double change =
      (table.at(ratio + 1e-3, tilt, radius, trace).k - table.at(ratio - 1e-3, tilt, radius, trace).k) / 2e-3;
  EXPECT_NEAR(table.at(ratio, tilt, radius, trace).per_ratio, change, 0.02 * std::abs(change));
  EXPECT_EQ(table.at(3, 0, radius, trace).k, 0);
}

TEST(Relaxation, BringsSevenFlatCirclesToTheirCriticalDistance) {
  const Sample x = hand_made::flat(200, 80);
  const hand_made::Charted charted(x);
  const auto begin = centres_at(charted, flower(33, 2));
  const Relaxation relaxation(charted, Half());
  const Arrangement out = relaxation.relaxed(begin, 20, 3, relaxation.middle_of(begin, 20));
  for (int i = 1; i < 7; ++i) {
    const Vector3d middle = static_cast<const ChartedSurface&>(charted).surface().place(out.centres[0].point);
    const Vector3d place = static_cast<const ChartedSurface&>(charted).surface().place(
        out.centres[static_cast<std::size_t>(i)].point);
    EXPECT_NEAR((place - middle).norm(), 30.3, 0.6);
  }
  EXPECT_LT(out.overlapping, 0.01);
  EXPECT_LT(out.apart, 0.022);  // circles with one between them
  EXPECT_EQ(out.outside_mm, 0);
}

TEST(Relaxation, KeepsCirclesOnTheChartAndOnTheirHalf) {
  const Sample x = hand_made::sphere(80, 260, 90, 60);
  const hand_made::Charted charted(x);
  std::vector<Vector2d> places = flower(30, 0);
  for (Vector2d& place : places) place += Vector2d(15, 34);
  const Relaxation all(charted, Half()), front(charted, Half{0, 1});
  const auto begin = centres_at(charted, places);
  std::vector<Vector2d> inside = flower(30, 0);
  for (Vector2d& place : inside) place += Vector2d(0, 12);
  const Middle about = all.middle_of(centres_at(charted, inside), 18);
  const Arrangement anywhere = all.relaxed(begin, 18, 3, about);
  EXPECT_LT(anywhere.outside_mm, 0.3);
  for (const Centre& c : front.relaxed(begin, 12, 3, about).centres)
    EXPECT_GT(static_cast<const ChartedSurface&>(charted).surface().place(c.point).y(), -0.5);
}

TEST(Relaxation, KeepsTheArrayAboutItsMiddle) {
  const Sample x = hand_made::sphere(80, 260, 90, 60);
  const hand_made::Charted charted(x);
  const Relaxation relaxation(charted, Half());
  std::vector<Vector2d> aside = flower(30, 1);
  for (Vector2d& place : aside) place += Vector2d(12, -7);
  const Middle about = relaxation.middle_of(centres_at(charted, flower(30, 0)), 18);
  const Arrangement out = relaxation.relaxed(centres_at(charted, aside), 18, 3, about);
  const Vector3d middle = relaxation.middle_of(out.centres, 18).place;
  EXPECT_LT((middle - about.place).head<2>().norm(), 1);
  EXPECT_NEAR(out.drift_mm, (middle - about.place).head<2>().norm(), 0.05);
  EXPECT_TRUE(out.is_whole());
  EXPECT_LT(out.overlapping, 0.012);
}

}  // namespace
}  // namespace vacuform::array_relaxation_test
