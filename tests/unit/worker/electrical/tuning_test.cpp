#include "worker/electrical/tuning.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace vacuform {
namespace {

// Flat strip loops of 60, 80 and 100 mm at 1.5, 3 and 7 T.
TEST(Tuning, CapacitorsOfRoundLoops) {
  const double loops[][4] = {
      {142.06, 43.71, 10.93, 2.02}, {178.20, 34.84, 8.71, 1.61}, {236.77, 26.23, 6.56, 1.21}};
  for (const auto& [nh, at_1, at_3, at_7] : loops) {
    EXPECT_NEAR(tuning_pf(nh, 63.87), at_1, 0.01);
    EXPECT_NEAR(tuning_pf(nh, 127.74), at_3, 0.01);
    EXPECT_NEAR(tuning_pf(nh, 297.2), at_7, 0.01);
  }
  EXPECT_NEAR(3 * proton_mhz_per_tesla, 127.73, 0.01);
}

// A loop of 80 mm and 5 mm: 50.3 squares of 10 mohm at 25.4 um, printed 10 um thick.
TEST(Tuning, QualityOfAPrintedLoop) { EXPECT_NEAR(quality(178.20, 127.74, 1.28), 112, 1); }

// Published noise figures of wire loops of 3 cm at 1, 1.5, 3, 7 and 9.4 T, and the ratios of qualities they follow from
// (Kumar and others 2009, Magnetic Resonance in Medicine 61, 1201).
TEST(Tuning, NoiseFigureOfARatioOfQualities) {
  const double figures[][2] = {{2.0, 3}, {2.8, 1.9}, {5.9, .8}, {22, .2}, {44, .1}};
  for (const auto& [ratio, db] : figures) EXPECT_NEAR(noise_figure_db(1, ratio - 1), db, 0.1 * db) << ratio;
}

// The loop with its capacitor: R + jwL - j/(wC1) in series, C2 across the port. Tuned with C1, its input is the port's.
TEST(Tuning, MatchingBringsTheLoopToThePort) {
  const double r = 5, z = 50, f = 127.74, w = 2e6 * M_PI * f, c = matching_pf(r, z, f) * 1e-12;
  // In parallel with C the loop must be R + jX with X = sqrt(R (Z - R)).
  const double x = std::sqrt(r * (z - r));
  const double real = r / (r * r + x * x), imaginary = -x / (r * r + x * x) + w * c;
  EXPECT_NEAR(real, 1 / z, 1e-9);
  EXPECT_NEAR(imaginary, 0, 1e-9);
  EXPECT_EQ(matching_pf(60, 50, f), 0);
}

TEST(Tuning, PreamplifiersBlockCoupledCurrents) {
  EXPECT_NEAR(coupled_current(-.0189, 178.2, 127.74, 10, 0), .27, .005);
  EXPECT_NEAR(coupled_current(.0189, 178.2, 127.74, 10, 90), .027, .0005);
}

TEST(Tuning, TakesTheNearestStandardValue) {
  EXPECT_DOUBLE_EQ(standard_value(34.8).pf, 36);
  EXPECT_NEAR(standard_value(34.8).detuning, std::sqrt(34.8 / 36) - 1, 1e-12);
  EXPECT_DOUBLE_EQ(standard_value(9.7).pf, 10);
  EXPECT_DOUBLE_EQ(standard_value(1.02).pf, 1);
  EXPECT_DOUBLE_EQ(standard_value(0.0301).pf, 0.03);
}

}  // namespace
}  // namespace vacuform
