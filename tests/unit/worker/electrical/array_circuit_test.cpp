#include "worker/electrical/array_circuit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "worker/coils/inductance.hpp"
#include "worker/electrical/tuning.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;

// A circle about an axis through `centre`, on a sphere of 95 mm.
std::vector<Vector3d> circle(const Vector3d& centre, const Vector3d& axis, double radius) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis);
  const double height = std::sqrt(95 * 95 - radius * radius);
  std::vector<Vector3d> out;
  for (int i = 0; i < 120; ++i) {
    const double a = 2 * M_PI * i / 120;
    out.push_back(centre + turn * Vector3d(radius * std::cos(a), radius * std::sin(a), height));
  }
  return out;
}

TEST(FitSphere, FindsOneOffTheOriginFromAPart) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 200; ++i) {
    const double a = 0.1 + 0.006 * i, b = 2.4 * i;
    points.emplace_back(12 + 85 * std::sin(a) * std::cos(b), -7 + 85 * std::sin(a) * std::sin(b),
                        31 + 85 * std::cos(a));
  }
  const auto found = fit_sphere(points);
  ASSERT_TRUE(found);
  EXPECT_LT((found->centre - Vector3d(12, -7, 31)).norm(), 1e-6);
  EXPECT_NEAR(found->radius_mm, 85, 1e-6);
  EXPECT_LT(found->rms_mm, 1e-6);
  EXPECT_FALSE(fit_sphere({points.begin(), points.begin() + 3}));
  for (Vector3d& p : points) p.z() = 0;
  EXPECT_FALSE(fit_sphere(points));
}

// Two loops of 80 mm and 5 mm, 10 mm over a sphere of 85 mm, their axes 37 degrees apart.
TEST(ArrayCircuit, IsThatOfTwoLoopsOverASphere) {
  const Vector3d centre(3, 20, -8), one = Vector3d(0.2, 0.1, 1).normalized(),
                                    other = Eigen::AngleAxisd(37 * M_PI / 180, one.unitOrthogonal()) * one;
  CircuitSettings settings;
  settings.ink_mohm = 25.4;  // 10 mohm at 25.4 um, 10 um thick
  std::vector<LoopOnPart> loops;
  for (const Vector3d& axis : {one, other}) {
    LoopOnPart loop;
    loop.line = circle(centre, axis, 40);
    loop.inductance_nh = self_inductance_nh(loop.line, 5);
    loop.squares = 2 * M_PI * 40 / 5;
    loop.gaps = 4;
    loops.push_back(loop);
  }
  const ArrayCircuit array = array_circuit(loops, {{centre, 85, 0}, 10}, settings);
  const LoopCircuit& loop = array.loops[1];
  EXPECT_NEAR(loop.coil_ohm, 1.28, 0.005);
  EXPECT_NEAR(loop.unloaded, 112, 1);
  EXPECT_NEAR(loop.body_ohm, 2.8793, 0.003);
  EXPECT_NEAR(loop.loaded, 178.2e-9 * 2e6 * M_PI * 127.74 / (1.277 + 2.879), 0.1);
  EXPECT_NEAR(loop.noise_db, 10 * std::log10(1 + 1.277 / 2.879), 0.01);
  EXPECT_GT(loop.most_body_ohm, loop.body_ohm);
  EXPECT_NEAR(array.noise(0, 1), .37082 * 2.879 / (2.879 + 1.277), 0.001);
  EXPECT_EQ(array.noise(1, 1), 1);
  EXPECT_NEAR(loop.capacitors[0].total_pf, 34.84, 0.05);
  EXPECT_NEAR(loop.capacitors[3].gap_pf, 34.8, 0.1);
  EXPECT_EQ(loop.capacitors[3].standard_pf, 36);
  EXPECT_NEAR(loop.capacitors[2].mhz, 298.04, 0.01);

  settings.ink_mohm *= 2;
  EXPECT_NEAR(array_circuit(loops, {{centre, 85, 0}, 10}, settings).loops[0].coil_ohm,
              2 * array.loops[0].coil_ohm, 1e-9);
}

}  // namespace
}  // namespace vacuform
