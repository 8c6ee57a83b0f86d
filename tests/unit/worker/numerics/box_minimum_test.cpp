#include "worker/numerics/box_minimum.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <random>

namespace vacuform {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Quadratic {
  MatrixXd A;
  VectorXd b;
};
// Two of its unknowns are hard to tell apart.
Quadratic random_quadratic(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  MatrixXd J(20, 4);
  for (double& entry : J.reshaped()) entry = normal(random);
  J.col(1) = J.col(0) + 0.05 * J.col(1);
  VectorXd best(4);
  for (double& entry : best) entry = 3 * normal(random);
  const MatrixXd A = J.transpose() * J;
  return {A, A * best};
}

TEST(BoxMinimum, IsTheFreeMinimumInAWideBox) {
  const Quadratic q = random_quadratic(1);
  const VectorXd wide = VectorXd::Constant(4, 1000);
  EXPECT_LT((box_minimum(q.A, q.b, -wide, wide) - q.A.ldlt().solve(q.b)).norm(), 1e-9);
}

// Karush, Kuhn and Tucker's conditions: inside, the slope is zero; on a bound, it points out of the box.
TEST(BoxMinimum, NoStepInTheBoxLeadsLower) {
  int on_bounds = 0, inside = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const Quadratic q = random_quadratic(seed);
    const VectorXd low = VectorXd::Constant(4, -1), high = VectorXd::Constant(4, 1.5);
    const VectorXd x = box_minimum(q.A, q.b, low, high), slope = q.A * x - q.b;
    for (int i = 0; i < 4; ++i) {
      ASSERT_GE(x[i], low[i]);
      ASSERT_LE(x[i], high[i]);
      if (x[i] == low[i])
        EXPECT_GT(slope[i], -1e-9) << seed;
      else if (x[i] == high[i])
        EXPECT_LT(slope[i], 1e-9) << seed;
      else
        EXPECT_NEAR(slope[i], 0, 1e-9) << seed;
      ++(x[i] == low[i] || x[i] == high[i] ? on_bounds : inside);
    }
  }
  EXPECT_GT(on_bounds, 20);
  EXPECT_GT(inside, 20);
}

TEST(BoxMinimum, ABoxWithoutWidthLeavesNoChoice) {
  const Quadratic q = random_quadratic(3);
  VectorXd low = VectorXd::Constant(4, -1), high = VectorXd::Constant(4, 1);
  low[2] = high[2] = 0.25;
  EXPECT_EQ(box_minimum(q.A, q.b, low, high)[2], 0.25);
}

}  // namespace
}  // namespace vacuform
