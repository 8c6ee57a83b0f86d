#include "worker/electrical/body_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "worker/electrical/tuning.hpp"

namespace vacuform {
namespace {

constexpr double degree = M_PI / 180;

// A loop of 40 mm radius at 95 mm from the centre of a sphere of 85 mm; the own resistance was also found by quadrature
// (2.8799 ohm).
TEST(BodyNoise, OfASphereIsTheSeries) {
  const ConductingSphere body{85, 0.6};
  const LoopOnSphere loop{95, std::asin(40.0 / 95)};
  const double own = noise_resistance(body, loop, loop, 0, 127.74);
  EXPECT_NEAR(own, 2.8793, 1e-4);
  const double ratios[][2] = {{20, .75012}, {30, .52514},  {37, .37082},   {45, .21913},
                              {60, .03225}, {90, -.11130}, {120, -.15452}, {180, -.17264}};
  for (const auto& [angle, ratio] : ratios)
    EXPECT_NEAR(noise_resistance(body, loop, loop, angle * degree, 127.74) / own, ratio, 1e-5) << angle;
}

TEST(BodyNoise, OfALargerSphere) {
  const ConductingSphere body{90, 0.5};
  const LoopOnSphere loop{95, std::asin(40.0 / 95)};
  const double own = noise_resistance(body, loop, loop, 0, 127.74);
  EXPECT_NEAR(own, 3.7724, 1e-4);
  const double ratios[][2] = {{37, .30927}, {60, .00167}, {90, -.09893}, {180, -.13677}};
  for (const auto& [angle, ratio] : ratios)
    EXPECT_NEAR(noise_resistance(body, loop, loop, angle * degree, 127.74) / own, ratio, 1e-5) << angle;
}

// The power of the sphere's field by direct integration: loops of different sizes and distances.
TEST(BodyNoise, IsSymmetricAndGrowsWithTheSquareOfTheFrequency) {
  const ConductingSphere body{80, 0.6};
  const LoopOnSphere small{83, 0.2}, large{100, 0.7};
  EXPECT_NEAR(noise_resistance(body, small, large, 0.5, 100), noise_resistance(body, large, small, 0.5, 100),
              1e-12);
  EXPECT_NEAR(noise_resistance(body, small, small, 0, 200) / noise_resistance(body, small, small, 0, 100), 4,
              1e-9);
  // A small loop close to a large sphere is one over a half space: radius 20 mm, 4 mm above one of 10 m.
  const LoopOnSphere over{std::hypot(10004.0, 20), std::atan(20 / 10004.0)};
  EXPECT_NEAR(noise_resistance({10000, 0.6}, over, over, 0, 100) / half_space_resistance(20, 4, 0.6, 100), 1,
              0.02);
}

TEST(BodyNoise, OfAHalfSpace) {
  const double values[][2] = {{0, 10.851}, {5, 8.411}, {10, 6.795}, {20, 4.785}};
  for (const auto& [above, ohm] : values)
    EXPECT_NEAR(half_space_resistance(40, above, 0.5, 127.74), ohm, 2e-3) << above;
}

// Loops of 3 cm of wire lose 3, 1.9, .8, .2 and .1 dB at 1, 1.5, 3, 7 and 9.4 T (Kumar et al., Magn Reson Med 61, 2009), as
// printed there with one figure. How far they lay from the body is chosen so that the first agrees.
TEST(BodyNoise, OfSmallLoopsAsMeasured) {
  const auto copper_ohm = [](double mhz) {  // a wire of 1 mm, whose current flows in its skin
    return 30.0 / 1 * std::sqrt(M_PI * mhz * 1e6 * 4e-7 * M_PI * 1.68e-8);
  };
  const auto noise_db = [&](double tesla, double above_mm) {
    const double mhz = tesla * proton_mhz_per_tesla;
    return noise_figure_db(copper_ohm(mhz), half_space_resistance(15, above_mm, 0.6, mhz));
  };
  double low = 0, high = 10;
  for (int i = 0; i < 40; ++i) (noise_db(1, (low + high) / 2) < 3 ? low : high) = (low + high) / 2;
  EXPECT_TRUE(low > 0.5 && low < 6) << low;
  const double measured[][2] = {{1, 3}, {1.5, 1.9}, {3, 0.8}, {7, 0.2}, {9.4, 0.1}};
  for (const auto& [tesla, db] : measured)
    EXPECT_NEAR(noise_db(tesla, low), db, std::max(0.1 * db, 0.05)) << tesla;
}

}  // namespace
}  // namespace vacuform
