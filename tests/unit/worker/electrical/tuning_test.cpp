#include "worker/electrical/tuning.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "worker/coils/inductance.hpp"

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

// The loop and its series capacitor in parallel with the one across the port are as the port.
TEST(Tuning, MatchingBringsTheLoopToThePort) {
  const double r = 5, z = 50, f = 127.74, w = 2e6 * M_PI * f;
  const Match found = match(178.2, r, z, f);
  const std::complex<double> j(0, 1), loop = r + j * w * 178.2e-9 + 1.0 / (j * w * found.series_pf * 1e-12);
  const std::complex<double> seen = 1.0 / (1.0 / loop + j * w * found.port_pf * 1e-12);
  EXPECT_NEAR(seen.real(), z, 1e-6);
  EXPECT_NEAR(seen.imag(), 0, 1e-6);
  EXPECT_EQ(match(178.2, 60, 50, f).port_pf, 0);
  EXPECT_DOUBLE_EQ(match(178.2, 60, 50, f).series_pf, tuning_pf(178.2, f));
}

// A tutorial of a full-wave program (openEMS, MRI_Loop_Coil.py): a loop of 80 x 60 mm outside and 5 mm strip with three
// capacitors of 5.4 pF resonates at 298 MHz, so it has 158.5 nH. At a corner the current goes from the middle of one side of
// the corner's square to the middle of the next.
TEST(Tuning, AgreesWithAFullWaveProgram) {
  const double x = 75 / 2., y = 55 / 2., strip = 5, corner = strip / 2, pf = 5.4 / 3;
  const Eigen::Vector2d turns[] = {{x - corner, -y}, {x, -y + corner}, {x, y - corner},  {x - corner, y},
                                   {corner - x, y},  {-x, y - corner}, {-x, corner - y}, {corner - x, -y}};
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 50; ++k) {
      const Eigen::Vector2d at = turns[i] + (turns[(i + 1) % 8] - turns[i]) * k / 50;
      line.emplace_back(at.x(), at.y(), 0);
    }
  const double nh = self_inductance_nh(line, strip),
               mhz = 1e4 * std::sqrt(10 / (nh * pf)) / (2 * std::numbers::pi);
  EXPECT_NEAR(tuning_pf(nh, mhz), pf, 1e-9);
  EXPECT_NEAR(mhz, 298, 0.02 * 298);
  EXPECT_NEAR(nh, 158.5, 0.04 * 158.5);
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
