// Every pair of an array, not neighbours alone.
#include "worker/coils/coupling_matrix.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "worker/coils/inductance.hpp"

namespace vacuform::coupling_matrix_test {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Points circle(const Vector3d& centre, double radius, const Vector3d& axis = Vector3d::UnitZ()) {
  const Vector3d u = axis.unitOrthogonal(), v = axis.normalized().cross(u);
  Points p;
  for (int i = 0; i < 120; ++i)
    p.push_back(centre + radius * (std::cos(2 * M_PI * i / 120) * u + std::sin(2 * M_PI * i / 120) * v));
  return p;
}

InductiveLoop loop(Points line, double width_mm) {
  const double self = self_inductance_nh(line, width_mm);
  return {std::move(line), self};
}

// One 80 mm circle of 5 mm strip and six around it, 1.51604 radii apart, where coplanar circles do not couple.
std::vector<InductiveLoop> critical_hexagon() {
  constexpr double radius = 40, apart = 1.51604 * radius;
  std::vector<InductiveLoop> loops{loop(circle({0, 0, 0}, radius), 5)};
  for (int i = 0; i < 6; ++i)
    loops.push_back(
        loop(circle(apart * Vector3d(std::cos(i * M_PI / 3), std::sin(i * M_PI / 3), 0), radius), 5));
  return loops;
}

TEST(CouplingMatrix, ShowsPairsBeyondTheNeighboursInACriticalHexagon) {
  const auto k = coupling_matrix(critical_hexagon(), Context());
  ASSERT_TRUE(k);
  ASSERT_EQ(k->count(), 7);
  for (int i = 1; i <= 6; ++i) {
    const auto rim = [](int j) { return 1 + j % 6; };
    EXPECT_NEAR((*k)(0, i), 0, 1e-3);
    EXPECT_NEAR((*k)(i, rim(i)), 0, 1e-3);             // neighbours on the rim
    EXPECT_NEAR((*k)(i, rim(i + 1)), -0.019, 0.0005);  // with one between them
    EXPECT_NEAR((*k)(i, rim(i + 2)), -0.011, 0.0005);  // across
    EXPECT_EQ((*k)(i, i), 1);
    for (int j = 0; j < 7; ++j) EXPECT_EQ((*k)(i, j), (*k)(j, i));
  }
  const auto strongest = strongest_pair(*k, [](int) { return true; });
  ASSERT_TRUE(strongest);
  EXPECT_NEAR(strongest->k, -0.019, 0.0005);
  EXPECT_GT(strongest->a, 0);
  // Without every other coil of the rim what couples most lies across or beside the middle.
  const auto others = strongest_pair(*k, [](int i) { return i == 0 || i == 1 || i == 4; });
  ASSERT_TRUE(others);
  EXPECT_EQ(std::pair(others->a, others->b), std::pair(1, 4));
}

// Just beyond the distance of dipoles, where they are worst.
TEST(CouplingMatrix, MatchesNeumannsIntegralWithin3e5ForFarLoops) {
  constexpr double radius = 10, far = 1.001 * dipole_distance * radius;
  const Points at_origin = circle({0, 0, 0}, radius);
  const double tilt = 0.7;
  Points rectangle;  // 4 to 1, as far as the circle reaches
  const double half = radius / std::sqrt(17.0);
  for (const auto& [x, y] : {std::pair{4.0, 1.0}, {-4.0, 1.0}, {-4.0, -1.0}, {4.0, -1.0}})
    rectangle.push_back(half * Vector3d(x, y, 0));
  for (Points& other :
       std::vector<Points>{circle({far, 0, 0}, radius), circle({0, 0, far}, radius),
                           circle({0.6 * far, 0, 0.8 * far}, radius, {std::sin(tilt), 0, std::cos(tilt)}),
                           circle({0, far, 0}, radius, Vector3d::UnitY()), circle({far, 0, 0}, radius / 4)}) {
    for (const Points& one : {at_origin, rectangle}) {
      const std::vector<InductiveLoop> both{loop(one, 2), loop(other, 2)};
      const auto k = coupling_matrix(both, Context());
      ASSERT_TRUE(k);
      const double exact = mutual_inductance_nh(one, other) / std::sqrt(both[0].self_nh * both[1].self_nh);
      EXPECT_NE((*k)(0, 1), exact);  // by dipoles
      EXPECT_NEAR((*k)(0, 1), exact, 3e-5);
    }
  }
  const std::vector<InductiveLoop> near{loop(at_origin, 2), loop(circle({0.99 * far, 0, 0}, radius), 2)};
  EXPECT_EQ((*coupling_matrix(near, Context()))(1, 0),
            mutual_inductance_nh(near[1].line, near[0].line) / std::sqrt(near[0].self_nh * near[1].self_nh));
}

TEST(CouplingMatrix, LeavesOutWhatHasNoInductanceAndCanBeCancelled) {
  std::vector<InductiveLoop> loops = critical_hexagon();
  loops[2].line.clear();
  loops[3].self_nh = 0;
  const auto k = coupling_matrix(loops, Context());
  ASSERT_TRUE(k);
  for (const int none : {2, 3})
    for (int i = 0; i < 7; ++i) EXPECT_TRUE(std::isnan((*k)(i, none)));
  EXPECT_FALSE(strongest_pair(*k, [](int i) { return i == 2 || i == 3; }));
  EXPECT_FALSE(strongest_pair(CouplingMatrix(), [](int) { return true; }));
  Context context;
  context.cancel();
  const auto cancelled = coupling_matrix(loops, context);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, Code::cancelled);
}

}  // namespace
}  // namespace vacuform::coupling_matrix_test
