// The slab against exact solutions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/worker/forming/heat/heaters.hpp"
#include "worker/forming/heat/slab.hpp"

namespace vacuform {
namespace {

constexpr double never = 0;

// Flux q into one face of a slab, insulated on the other, all opaque: the exact series. At absolute zero, where nothing
// is radiated back.
TEST(Slab, FollowsTheExactSeries) {
  const double L = 1e-3, k = 0.2, diffusivity = 0.2 / (1270.0 * 1250.0), q = 50;
  constexpr int n = 64;
  const Slab slab({1270, 1250, k, 1, INFINITY}, 1, n);
  std::vector<double> celsius(n, absolute_zero);
  const double step = 0.01;
  double taken = 0;
  const auto exact = [&](double z, double t) {
    const double fourier = diffusivity * t / (L * L);
    double sum = 0;
    for (int m = 1; m < 200; ++m)
      sum += (m % 2 ? -1.0 : 1.0) / (m * m) *
             std::exp(-m * m * std::numbers::pi * std::numbers::pi * fourier) *
             std::cos(m * std::numbers::pi * z / L);
    return fourier + (3 * z * z - L * L) / (6 * L * L) - 2 / (std::numbers::pi * std::numbers::pi) * sum;
  };
  int compared = 0;
  for (int i = 1; i <= 2000; ++i) {
    taken += slab.advance(celsius, step, {q, never, 0}, {0, never, 0});
    if (i != 100 && i != 400 && i != 1000 && i != 2000) continue;
    for (int j = 0; j < n; ++j) {
      const double z = L * (1 - (j + 0.5) / n);  // the flux comes in at the top, z = L
      EXPECT_NEAR((celsius[j] - absolute_zero) * k / (q * L), exact(z, i * step), 1e-4)
          << i << ", layer " << j;
    }
    EXPECT_NEAR((Slab::top_celsius(celsius) - absolute_zero) * k / (q * L), exact(L, i * step), 2e-4);
    ++compared;
  }
  EXPECT_EQ(compared, 4);
  EXPECT_NEAR(taken / (q * 2000 * step), 1, 1e-9);
}

// All that comes in, by radiation in depth, air and re-radiation, is found again as energy of the sheet.
TEST(Slab, BalancesItsEnergy) {
  const Slab slab({1200, 1200, 0.2, 0.94, 3}, 0.8, 16);
  std::vector<double> celsius(16, 23);
  const double before = slab.energy(celsius);
  double taken = 0;
  for (int i = 0; i < 60; ++i) taken += slab.advance(celsius, 0.5, {14000, 8, 60}, {3000, 6, 40});
  EXPECT_GT(celsius[0], 100);
  EXPECT_NEAR(taken / (slab.energy(celsius) - before), 1, 1e-7);
}

// Without conduction each layer takes what Beer and Lambert leave it.
TEST(Slab, AbsorbsInDepth) {
  const Slab slab({1000, 1000, 1e-9, 0.9, 2}, 1, 10);
  std::vector<double> celsius(10, absolute_zero);
  slab.advance(celsius, 0.1, {40, never, 0}, {0, never, 0});
  for (int i = 0; i < 10; ++i) {
    const double share = std::exp(-0.2 * i) - std::exp(-0.2 * (i + 1));
    EXPECT_NEAR((celsius[i] - absolute_zero) / (0.1 * 40 * 0.9 * share / 100), 1, 1e-6) << i;
  }
}

// A slab of high conductivity cools as one lump: exp(-2 h t / (rho c L)).
TEST(Slab, CoolsInAirAsALump) {
  const Slab slab({1000, 1000, 1e4, 0, 5}, 1, 8);
  std::vector<double> celsius(8, 150);
  for (int i = 0; i < 100; ++i) slab.advance(celsius, 0.5, {0, 10, 20}, {0, 10, 20});
  EXPECT_NEAR(celsius[3], 20 + 130 * std::exp(-2 * 10 * 50 / 1000.0), 0.01);
}

// Long steps under a fierce heater end in the balance of what comes in and what is radiated back.
TEST(Slab, ComesToRestInLongSteps) {
  const Slab slab({1270, 1250, 0.2, 0.94, 3}, 1, 10);
  std::vector<double> celsius(10, 23);
  for (int i = 0; i < 20; ++i) slab.advance(celsius, 90, {black(1200), 0, 23}, {black(1200), 0, 23});
  for (const double c : celsius) EXPECT_NEAR(c, 1200, 1e-3);
}

TEST(Slab, KeepsTheTemperatureOfItsSurroundings) {
  const Slab slab({1000, 1000, 0.2, 0.9, 1.5}, 1, 16);
  std::vector<double> celsius(16, 130);
  for (int i = 0; i < 50; ++i) slab.advance(celsius, 2, {black(130), 8, 130}, {black(130), 8, 130});
  for (const double c : celsius) EXPECT_NEAR(c, 130, 1e-9);
}

}  // namespace
}  // namespace vacuform
