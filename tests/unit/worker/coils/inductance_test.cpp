// The exact values of PHYSICS.md's coils.
#include "worker/coils/inductance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <vector>

namespace vacuform::inductance_test {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

// A circle as a polygon of the same area.
Points circle(const Vector3d& centre, double radius, int n = 120) {
  const double out = radius * std::sqrt(2 * M_PI / n / std::sin(2 * M_PI / n));
  Points p;
  for (int i = 0; i < n; ++i)
    p.push_back(centre + out * Vector3d(std::cos(2 * M_PI * i / n), std::sin(2 * M_PI * i / n), 0));
  return p;
}

// Where a falling function of one distance is zero.
double zero_of(const std::function<double(double)>& f, double low, double high) {
  for (int i = 0; i < 30; ++i) {
    const double middle = (low + high) / 2;
    (f(middle) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

TEST(Inductance, MatchesMaxwellsEllipticIntegralForCoaxialCircles) {
  for (const auto& [a, b, z] : {std::array{40.0, 40.0, 30.0}, {40.0, 25.0, 5.0}, {20.0, 30.0, 80.0}}) {
    const double m = std::sqrt(4 * a * b / ((a + b) * (a + b) + z * z));
    const double exact =
        0.4 * M_PI * std::sqrt(a * b) * ((2 / m - m) * std::comp_ellint_1(m) - 2 / m * std::comp_ellint_2(m));
    const Points p = circle({0, 0, 0}, a), q = circle({0, 0, z}, b);
    EXPECT_NEAR(mutual_inductance_nh(p, q, 0) / exact, 1, 1e-3) << a << ' ' << b << ' ' << z;
    EXPECT_NEAR(mutual_inductance_nh(q, p, 0), mutual_inductance_nh(p, q, 0), 1e-3 * std::abs(exact));
  }
}

TEST(Inductance, MatchesALoopOfStrip) {
  // L = mu0 a [ln(8 a / b) - 2], b = width / 4: 178 nH.
  const double exact = 0.4 * M_PI * 40 * (std::log(8 * 40 / 1.25) - 2);
  EXPECT_NEAR(exact, 178, 0.5);
  EXPECT_NEAR(self_inductance_nh(circle({0, 0, 0}, 40), 5), exact, 0.6);
  EXPECT_NEAR(self_inductance_nh(circle({0, 0, 0}, 20, 96), 3),
              0.4 * M_PI * 20 * (std::log(8 * 20 / 0.75) - 2), 0.4);
}

TEST(Inductance, VanishesForCoplanarCirclesAt1516Radii) {
  const Points a = circle({0, 0, 0}, 40);
  const auto k = [&](double d) { return coupling(a, 5, circle({d, 0, 0}, 40), 5); };
  EXPECT_NEAR(zero_of(k, 50, 75), 1.51604 * 40, 0.1);
  EXPECT_NEAR((k(61) - k(60)) / 1, -0.0071, 0.0007);
}

TEST(Inductance, OfMutualCirclesOnASphereVanishesAt5891) {
  constexpr double radius = 85, angle = 40 / radius;
  const auto loop = [&](double d) {
    const Eigen::AngleAxisd turn(d / radius, Vector3d::UnitY());
    Points p;
    for (const Vector3d& x : circle({0, 0, radius * std::cos(angle)}, radius * std::sin(angle)))
      p.push_back(turn * x);
    return p;
  };
  const Points a = loop(0);
  EXPECT_NEAR(zero_of([&](double d) { return coupling(a, 5, loop(d), 5); }, 50, 70), 58.91, 0.1);
}

TEST(Inductance, CrossingAndTouchingLoopsHaveAFiniteValueThatHardlyHangsOnTheGap) {
  const Points a = circle({0, 0, 0}, 20), b = circle({30.32, 0, 0}, 20), same = a;
  const double k = mutual_inductance_nh(a, b, 0.1);
  EXPECT_TRUE(std::isfinite(mutual_inductance_nh(a, b, 1e-6)));
  EXPECT_NEAR(mutual_inductance_nh(a, b, 0.05), k, 0.1);
  EXPECT_TRUE(std::isfinite(mutual_inductance_nh(a, same, 0.1)));
  // The other sense turns the sign.
  const Points back(b.rbegin(), b.rend());
  EXPECT_NEAR(mutual_inductance_nh(a, back, 0.1), -k, 1e-3);
}

}  // namespace
}  // namespace vacuform::inductance_test
