// The energies of single triangles and small charts, against hand calculation and finite differences.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "tests/unit/worker/flattening/flattening_charts.hpp"
#include "worker/flattening/symmetric_dirichlet_energy.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {
namespace {

Eigen::Matrix2d matrix(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

const std::vector<Eigen::Matrix2d> maps = {
    matrix(1, 0, 0, 1),          matrix(0, -1, 1, 0),           matrix(2, 0, 0, 1),
    matrix(0.3, 0.1, -0.2, 0.5), matrix(-1, 0.2, 0.1, -2),      matrix(1, 50, 0, 1),
    matrix(0.01, 0, 0, 3),       matrix(0.7, -0.7, 0.7, 0.7),   matrix(5, 3, -3, 5),
    matrix(0.9, 1e-9, 0, 0.9),   matrix(0.05, 0.02, 0.01, 0.06)};

TEST(SymmetricDirichlet, ByHand) {
  EXPECT_NEAR(symmetric_dirichlet(matrix(1, 0, 0, 1)), 4, 1e-15);
  EXPECT_NEAR(symmetric_dirichlet(matrix(2, 0, 0, 1)), 4 + 1 + 0.25 + 1, 1e-15);
  EXPECT_NEAR(symmetric_dirichlet(matrix(0, -2, 0.5, 0)), 4 + 0.25 + 0.25 + 4, 1e-14);
  EXPECT_TRUE(std::isinf(symmetric_dirichlet(matrix(1, 0, 0, -1))));
  EXPECT_TRUE(std::isinf(symmetric_dirichlet(matrix(1, 2, 2, 4))));
}

TEST(SymmetricDirichlet, GradientByFiniteDifferences) {
  for (const auto& J : maps) {
    const SymmetricDirichlet e = symmetric_dirichlet_expansion(J);
    EXPECT_NEAR(e.energy, symmetric_dirichlet(J), 1e-9 * e.energy);
    const double h = 1e-6 * std::min(J.norm(), J.determinant() / J.norm());
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) {
        Eigen::Matrix2d more = J, less = J;
        more(i, j) += h, less(i, j) -= h;
        EXPECT_NEAR((symmetric_dirichlet(more) - symmetric_dirichlet(less)) / (2 * h), e.gradient(i, j),
                    1e-5 * (1 + e.gradient.norm()));
      }
  }
}

// The Hessian by differences of the gradient, with its negative eigenvalues made 0, is what the eigensystem gives.
TEST(SymmetricDirichlet, HessianByFiniteDifferences) {
  int clamped = 0;
  for (const auto& J : maps) {
    const SymmetricDirichlet e = symmetric_dirichlet_expansion(J);
    EXPECT_LT((e.directions.transpose() * e.directions - Eigen::Matrix4d::Identity()).norm(), 1e-12);
    EXPECT_GE(e.eigenvalues.minCoeff(), 0);
    const double h = 1e-6 * std::min(J.norm(), J.determinant() / J.norm());
    Eigen::Matrix4d H;
    for (int k = 0; k < 4; ++k) {
      Eigen::Matrix2d more = J, less = J;
      more.reshaped()[k] += h, less.reshaped()[k] -= h;
      H.col(k) =
          ((symmetric_dirichlet_expansion(more).gradient - symmetric_dirichlet_expansion(less).gradient) /
           (2 * h))
              .reshaped();
    }
    H = (H + H.transpose()).eval() / 2;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(H);
    clamped += eigen.eigenvalues()[0] < -1e-3;
    const Eigen::Matrix4d expected = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
                                     eigen.eigenvectors().transpose();
    const Eigen::Matrix4d given = e.directions * e.eigenvalues.asDiagonal() * e.directions.transpose();
    EXPECT_LT((given - expected).norm(), 1e-4 * expected.norm()) << J;
  }
  EXPECT_GT(clamped, 2);  // or the projection was never needed
}

TEST(Elements, MapTheirPlaneToTheChart) {
  const Chart chart = grid_chart(1, 1, [](double x, double y) { return Eigen::Vector3d(2 * x, y, 2 * x); });
  const auto all = elements(chart);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Matrix2d J = jacobian(chart, all, k);
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(J);
    EXPECT_NEAR(svd.singularValues()[0], 1, 1e-12);
    EXPECT_NEAR(svd.singularValues()[1], 1 / std::sqrt(8), 1e-12);
    EXPECT_GT(J.determinant(), 0);
    EXPECT_NEAR(all[k].area, std::sqrt(8) / 2, 1e-12);
  }
}

TEST(Elements, ATriangleWithoutAreaHasAMap) {
  Chart chart = grid_chart(1, 1, [](double x, double) { return Eigen::Vector3d(x, 0, 0); });
  chart.inked[1] = chart.inked[0];
  for (const ChartElement& e : elements(chart)) {
    EXPECT_TRUE(e.gradient.allFinite());
    EXPECT_GT(e.area, 0);
  }
}

TEST(ChartQuality, CountsFlipsAndEnergies) {
  Chart chart = grid_chart(1, 1, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  EXPECT_NEAR(chart_quality(chart).arap, 0, 1e-12);
  EXPECT_NEAR(chart_quality(chart).symmetric_dirichlet, 4, 1e-12);
  for (auto& p : chart.uv) p.x() *= 2;
  EXPECT_NEAR(chart_quality(chart).arap, 1, 1e-12);  // stretched by 2 one way: (2 - 1)^2
  EXPECT_NEAR(chart_quality(chart).symmetric_dirichlet, 6.25, 1e-12);
  EXPECT_EQ(chart_quality(chart).flipped, 0);
  for (auto& p : chart.uv) p.x() *= -0.5;
  EXPECT_NEAR(chart_quality(chart).arap, 4, 1e-12);  // the mirror's s2 is -1: (-1 - 1)^2
  EXPECT_TRUE(std::isinf(chart_quality(chart).symmetric_dirichlet));
  EXPECT_EQ(chart_quality(chart).flipped, 2);
}

TEST(BorderLoops, GoAroundTheChartAndItsHoles) {
  Chart chart = grid_chart(4, 4, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  auto loops = border_loops(chart.triangles);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].size(), 16u);
  double twice = 0;
  for (std::size_t i = 0; i < 16; ++i) {
    const auto &a = chart.uv[loops[0][i]], &b = chart.uv[loops[0][(i + 1) % 16]];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  EXPECT_NEAR(twice / 2, 16, 1e-12);  // counter-clockwise
  chart.triangles.erase(chart.triangles.begin() + 10, chart.triangles.begin() + 12);
  loops = border_loops(chart.triangles);
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(loops[1].size(), 4u);
}

}  // namespace
}  // namespace vacuform
