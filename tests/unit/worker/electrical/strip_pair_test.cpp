#include "worker/electrical/strip_pair.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace vacuform {
namespace {

constexpr double mu0 = 0.4 * M_PI;  // nH/mm

TEST(StripPair, HasTheInductanceOfVacuumWhereBothIntegralsAreEqual) {
  const double between = 1.5 * 2 / (std::sqrt(2.0) - 1);  // k = k'
  EXPECT_NEAR(strip_pair_nh_per_mm(1.5, between), mu0, 1e-9);
}

TEST(StripPair, OfNarrowStripsIsAPairOfWires) {
  // A strip is a round wire of a quarter of its width.
  for (const double width : {0.01, 0.1})
    EXPECT_NEAR(strip_pair_nh_per_mm(width, 10) / (mu0 / M_PI * std::log((10 + width) / (width / 4))), 1,
                0.001)
        << width;
}

TEST(StripPair, OfTheUsualTailIsSevenTenthsOfANanohenryAMillimetre) {
  EXPECT_NEAR(strip_pair_nh_per_mm(1.5, 0.9), 0.6953, 0.0002);
}

}  // namespace
}  // namespace vacuform
