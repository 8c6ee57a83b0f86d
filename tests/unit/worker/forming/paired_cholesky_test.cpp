#include "worker/numerics/paired_cholesky.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "worker/forming/sheet_grid.hpp"

namespace vacuform::paired_cholesky_test {
namespace {

using Quad = PairedCholesky::Quad;

struct System {
  Dissection dissection;
  std::vector<std::array<int, 3>> triangles;
  std::vector<PairedCholesky::Element> elements;
};

// A grid of 300 mm whose vertices beyond `reach` from the middle are held, with random positive definite elements.
System random_system(double resolution_mm, double reach) {
  SheetSettings sheet;
  sheet.resolution_mm = resolution_mm;
  const SheetGrid grid = make_sheet_grid(sheet, {});
  System system{grid.dissection, {}, {}};
  std::vector<int> row(grid.rest.size(), -1);
  int rows = 0;
  for (auto& part : system.dissection.parts) {
    const int begin = rows;
    for (int k = part.begin; k < part.end; ++k)
      if (const int v = grid.elimination_order[k]; grid.rest[v].norm() < reach) row[v] = rows++;
    part.begin = begin, part.end = rows;
  }
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (const Triangle& t : grid.triangles) {
    system.triangles.push_back({row[t[0]], row[t[1]], row[t[2]]});
    PairedCholesky::Element element;
    for (auto& entries : element) {
      Eigen::Matrix3f a;
      for (float& entry : a.reshaped()) entry = uniform(random);
      const Eigen::Matrix3f k = a * a.transpose() + 0.1f * Eigen::Matrix3f::Identity();
      entries = {k(0, 0), k(1, 0), k(1, 1), k(2, 0), k(2, 1), k(2, 2)};
    }
    system.elements.push_back(element);
  }
  return system;
}

Eigen::MatrixXd dense(const System& system, int which) {
  const int rows = system.dissection.parts.back().end;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t k = 0; k < system.triangles.size(); ++k) {
    const auto& t = system.triangles[k];
    int entry = 0;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b <= a; ++b, ++entry) {
        if (t[a] < 0 || t[b] < 0) continue;
        const double value = double(system.elements[k][which][entry]);
        matrix(t[a], t[b]) += value;
        if (a != b) matrix(t[b], t[a]) += value;
      }
  }
  return matrix;
}

std::vector<Quad> columns_for(const System& system) {
  std::vector<Quad> columns;
  for (int k = 0; k < system.dissection.parts.back().end; ++k)
    columns.emplace_back(1, std::sin(float(k)), k == 17 ? 1 : 0, std::cos(float(3 * k)));
  return columns;
}

TEST(PairedCholesky, SolvesThreeColumnsWithOneMatrixAndOneWithTheOther) {
  for (const double reach : {40.0, 110.0, 130.0}) {
    const System system = random_system(10, reach);
    PairedCholesky cholesky;
    cholesky.analyse(system.dissection, system.triangles);
    ASSERT_TRUE(cholesky.factor(system.elements));
    const std::vector<Quad> b = columns_for(system);
    std::vector<Quad> x = b;
    cholesky.solve(x);
    const Eigen::MatrixXd first = dense(system, 0), second = dense(system, 1);
    for (int column = 0; column < 4; ++column) {
      Eigen::VectorXd rhs(first.rows()), solution(first.rows());
      for (Eigen::Index k = 0; k < rhs.size(); ++k)
        rhs[k] = double(b[k][column]), solution[k] = double(x[k][column]);
      const Eigen::VectorXd exact = (column < 3 ? first : second).lu().solve(rhs);
      EXPECT_LT((solution - exact).norm(), 1e-4 * exact.norm()) << reach << " " << column;
    }
  }
}

TEST(PairedCholesky, GivesTheSameBytesAtAnyNumberOfThreads) {
  const System system = random_system(2, 140);
  std::vector<std::vector<Quad>> solutions;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    PairedCholesky cholesky;
    cholesky.analyse(system.dissection, system.triangles);
    ASSERT_TRUE(cholesky.factor(system.elements));
    solutions.push_back(columns_for(system));
    cholesky.solve(solutions.back());
  }
  for (const auto& solution : solutions)
    EXPECT_EQ(std::memcmp(solution.data(), solutions[0].data(), solution.size() * sizeof(Quad)), 0);
}

TEST(PairedCholesky, GivesTheSameBytesWithoutAvx2) {
  const System system = random_system(2, 140);
  std::vector<std::vector<Quad>> solutions;
  for (PairedCholesky cholesky : {PairedCholesky(), PairedCholesky(false)}) {
    cholesky.analyse(system.dissection, system.triangles);
    ASSERT_TRUE(cholesky.factor(system.elements));
    solutions.push_back(columns_for(system));
    cholesky.solve(solutions.back());
  }
  EXPECT_EQ(std::memcmp(solutions[0].data(), solutions[1].data(), solutions[0].size() * sizeof(Quad)), 0);
}

TEST(PairedCholesky, RefusesWhatIsNoNumber) {
  System system = random_system(10, 100);
  PairedCholesky cholesky;
  cholesky.analyse(system.dissection, system.triangles);
  for (auto& value : system.elements[system.elements.size() / 2 + 30][1])
    value = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(cholesky.factor(system.elements));
}

TEST(PairedCholesky, RefusesPartsThatAreJoinedBesideTheirSeparator) {
  Dissection dissection;
  dissection.parts = {{0, 1}, {1, 2}, {2, 3, 0, 1}};
  const std::vector<std::array<int, 3>> joined{{0, 1, 2}};
  PairedCholesky cholesky;
  EXPECT_THROW(cholesky.analyse(dissection, joined), std::logic_error);
}

}  // namespace
}  // namespace vacuform::paired_cholesky_test
