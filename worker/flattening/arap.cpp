#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "worker/flattening/chart.hpp"
#include "worker/forming/sparse_cholesky.hpp"

namespace vacuform {

namespace {

struct Element {
  std::array<Eigen::Vector2d, 3> edge;  // edge k runs from corner k to corner k + 1, in the triangle's plane
  std::array<double, 3> cot;            // of the angle opposite edge k
};

std::vector<Element> elements(const Chart& chart) {
  std::vector<Element> all;
  all.reserve(chart.triangles.size());
  for (const Triangle& t : chart.triangles) {
    const FlatTriangle f = flat_triangle(chart.inked[t[0]], chart.inked[t[1]], chart.inked[t[2]]);
    Element e{};
    const double twice_area = f.length * f.height;
    if (twice_area > 1e-12) {
      const Eigen::Vector2d p[3] = {{0, 0}, {f.length, 0}, {f.along, f.height}};
      for (int k = 0; k < 3; ++k) e.edge[k] = p[(k + 1) % 3] - p[k];
      for (int k = 0; k < 3; ++k) e.cot[k] = -e.edge[(k + 1) % 3].dot(e.edge[(k + 2) % 3]) / twice_area;
    }  // else a triangle without area: no weight
    all.push_back(e);
  }
  return all;
}

// The cotangent Laplacian without the row and column of vertex 0, which stays where it is.
SymmetricMatrix laplacian(const Chart& chart, const std::vector<Element>& all) {
  const int n = static_cast<int>(chart.uv.size());
  std::vector<std::vector<std::pair<int, double>>> columns(n);
  std::vector<double> diagonal(n, 1e-12);  // keeps a vertex without weight from making the matrix singular
  for (std::size_t k = 0; k < all.size(); ++k)
    for (int e = 0; e < 3; ++e) {
      const int a = chart.triangles[k][e], b = chart.triangles[k][(e + 1) % 3];
      const double w = all[k].cot[e];
      diagonal[a] += w;
      diagonal[b] += w;
      columns[std::min(a, b)].push_back({std::max(a, b), -w});
    }
  SymmetricMatrix matrix;
  matrix.size = n - 1;
  matrix.column_start.push_back(0);
  for (int c = 1; c < n; ++c) {
    auto& entries = columns[c];
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    matrix.row.push_back(c - 1);
    matrix.value.push_back(diagonal[c]);
    for (const auto& [r, value] : entries)
      if (matrix.row.back() == r - 1) {
        matrix.value.back() += value;
      } else {
        matrix.row.push_back(r - 1);
        matrix.value.push_back(value);
      }
    matrix.column_start.push_back(static_cast<int>(matrix.row.size()));
  }
  return matrix;
}

}  // namespace

Result<FlatteningOutcome> flatten_arap(Chart& chart, const Context& context) {
  constexpr int most_iterations = 300;
  constexpr double least_gain = 1e-6;
  const auto all = elements(chart);
  const SymmetricMatrix L = laplacian(chart, all);
  SparseCholesky cholesky;
  cholesky.analyse(L);
  if (!cholesky.factor(L)) throw std::logic_error("the cotangent Laplacian is not positive definite");

  const Eigen::Index n = static_cast<Eigen::Index>(chart.uv.size());
  const Eigen::Vector2d pin = chart.uv[0];
  Eigen::MatrixXd full(n, 2), rhs(n - 1, 2), solution;
  FlatteningOutcome outcome;
  double energy = chart_quality(chart).energy;
  while (outcome.iterations < most_iterations && !outcome.converged) {
    VACUFORM_CHECK(context.step(Stage::flattening, 1 - 1 / (1 + 0.1 * outcome.iterations)));
    full.setZero();
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Triangle& t = chart.triangles[k];
      // Local: the rotation nearest to the triangle's present map, from its cotangent-weighted covariance.
      double c = 0, s = 0;
      for (int e = 0; e < 3; ++e) {
        const Eigen::Vector2d &x = all[k].edge[e], u = chart.uv[t[(e + 1) % 3]] - chart.uv[t[e]];
        c += all[k].cot[e] * (x.x() * u.x() + x.y() * u.y());
        s += all[k].cot[e] * (x.x() * u.y() - x.y() * u.x());
      }
      const double norm = std::hypot(c, s);
      if (norm == 0)
        c = 1, s = 0;
      else
        c /= norm, s /= norm;
      for (int e = 0; e < 3; ++e) {
        const Eigen::Vector2d& x = all[k].edge[e];
        const double w = all[k].cot[e];
        const Eigen::RowVector2d turned(w * (c * x.x() - s * x.y()), w * (s * x.x() + c * x.y()));
        full.row(t[(e + 1) % 3]) += turned;
        full.row(t[e]) -= turned;
      }
    }
    // Global: one solve for both coordinates, relative to the vertex that stays.
    rhs = full.bottomRows(n - 1);
    cholesky.solve(rhs, solution);
    for (Eigen::Index i = 1; i < n; ++i) chart.uv[i] = pin + solution.row(i - 1).transpose();
    ++outcome.iterations;
    const double now = chart_quality(chart).energy;
    outcome.converged = energy - now <= least_gain * energy;
    energy = now;
  }
  return outcome;
}

}  // namespace vacuform
