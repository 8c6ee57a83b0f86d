// The supernodal factorization, against dense ones.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "tests/unit/worker/flattening/flattening_charts.hpp"
#include "worker/flattening/chart_matrix.hpp"
#include "worker/numerics/supernodal_cholesky.hpp"

namespace vacuform {
namespace {

Eigen::MatrixXd dense(const SymmetricMatrix& matrix) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(matrix.size, matrix.size);
  for (int c = 0; c < matrix.size; ++c)
    for (int k = matrix.column_start[c]; k < matrix.column_start[c + 1]; ++k)
      A(matrix.row[k], c) = A(c, matrix.row[k]) = matrix.value[k];
  return A;
}

// A chart's matrix of random positive definite triangles, and the same as the sum of dense ones.
template <int D>
struct Random {
  ChartMatrix<D> matrix;
  Eigen::MatrixXd A;

  explicit Random(const Chart& chart, double diagonal = 0.1) : matrix(chart) {
    const auto n = static_cast<Eigen::Index>(D * chart.uv.size());
    A = diagonal * Eigen::MatrixXd::Identity(n, n);
    matrix.reset(diagonal);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (std::size_t k = 0; k < chart.triangles.size(); ++k) {
      typename ChartMatrix<D>::Local half;
      for (auto& x : half.reshaped()) x = any(random);
      const typename ChartMatrix<D>::Local local = half * half.transpose();
      matrix.add(k, local);
      for (int i = 0; i < 3 * D; ++i)
        for (int j = 0; j < 3 * D; ++j)
          A(D * chart.triangles[k][i / D] + i % D, D * chart.triangles[k][j / D] + j % D) += local(i, j);
    }
  }
};

const Chart grid = grid_chart(19, 13, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });

TEST(ChartMatrix, IsTheSumOfItsTriangles) {
  const Random<1> one(grid);
  EXPECT_LT((dense(one.matrix.matrix()) - one.A).norm(), 1e-12);
  const Random<2> two(grid);
  EXPECT_LT((dense(two.matrix.matrix()) - two.A).norm(), 1e-12);
}

TEST(SupernodalCholesky, SolvesForOneAndTwoColumns) {
  const Random<1> one(grid);
  SupernodalCholesky cholesky(one.matrix.matrix());
  ASSERT_TRUE(cholesky.factor(one.matrix.matrix()));
  SupernodalCholesky::Columns<2> B = Eigen::MatrixXd::Random(one.A.rows(), 2), X = B;
  cholesky.solve(X);
  EXPECT_LT((one.A * X - B).norm(), 1e-9);
}

TEST(SupernodalCholesky, SolvesForGroupsAndRepeats) {
  const Random<2> two(grid);
  SupernodalCholesky grouped(two.matrix.matrix(), 2), single(two.matrix.matrix());
  Eigen::VectorXd b = Eigen::VectorXd::Random(two.A.rows()), first, x;
  for (SupernodalCholesky* cholesky : {&grouped, &single})
    for (int time = 0; time < 2; ++time) {
      ASSERT_TRUE(cholesky->factor(two.matrix.matrix()));
      x = b;
      cholesky->solve(x);
      EXPECT_LT((two.A * x - b).norm(), 1e-9);
      if (time > 0) {
        EXPECT_EQ(x, first);
      }
      first = x;
    }
}

TEST(SupernodalCholesky, RefusesWhatIsNotPositiveDefinite) {
  Random<1> one(grid);
  SupernodalCholesky cholesky(one.matrix.matrix());
  one.matrix.shift_diagonal(-1.2 * Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(one.A).eigenvalues()[0]);
  EXPECT_FALSE(cholesky.factor(one.matrix.matrix()));
  one.matrix.reset(1);
  EXPECT_TRUE(cholesky.factor(one.matrix.matrix()));
}

TEST(SupernodalCholesky, SeparateParts) {
  Chart two = grid_chart(2, 2, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  const int n = static_cast<int>(two.uv.size());
  const auto triangles = two.triangles;
  for (const auto& t : triangles) two.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  two.uv.resize(2 * two.uv.size());
  const Random<1> one(two);
  SupernodalCholesky cholesky(one.matrix.matrix());
  ASSERT_TRUE(cholesky.factor(one.matrix.matrix()));
  SupernodalCholesky::Columns<2> B = Eigen::MatrixXd::Random(2 * n, 2), X = B;
  cholesky.solve(X);
  EXPECT_LT((one.A * X - B).norm(), 1e-9);
}

}  // namespace
}  // namespace vacuform
