#include "worker/electrical/body_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace vacuform
