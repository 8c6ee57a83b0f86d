// The symmetric matrices of a chart: D unknowns per vertex, coupled within every triangle.
#pragma once

#include <algorithm>
#include <array>

#include "worker/flattening/chart.hpp"
#include "worker/numerics/symmetric_matrix.hpp"

namespace vacuform {

// Unknown D v + d is coordinate d of vertex v. The pattern is made once. The target of each entry of a triangle matrix
// is stored, so filling reads memory in order.
template <int D>
class ChartMatrix {
 public:
  using Local = Eigen::Matrix<double, 3 * D, 3 * D>;  // row D k + d: coordinate d of corner k

  explicit ChartMatrix(const Chart& chart);

  // Zero except for the diagonal.
  void reset(double diagonal);
  // Adds the symmetric matrix of a triangle. Only its lower half is read.
  void add(std::size_t triangle, const Local& local) {
    const auto& slot = slots_[triangle];
    for (int i = 0, k = 0; i < 3 * D; ++i)
      for (int j = 0; j <= i; ++j) matrix_.value[slot[k++]] += local(i, j);
  }
  void shift_diagonal(double by) {
    for (int c = 0; c < matrix_.size; ++c) matrix_.value[matrix_.column_start[c]] += by;
  }
  const SymmetricMatrix& matrix() const { return matrix_; }

 private:
  SymmetricMatrix matrix_;
  std::vector<std::array<int, 3 * D*(3 * D + 1) / 2>> slots_;
};

template <int D>
ChartMatrix<D>::ChartMatrix(const Chart& chart) {
  const std::size_t n = chart.uv.size();
  // The neighbours above each vertex, ascending.
  std::vector<std::vector<int>> above(n);
  for (const Triangle& t : chart.triangles)
    for (int e = 0; e < 3; ++e)
      above[std::min(t[e], t[(e + 1) % 3])].push_back(std::max(t[e], t[(e + 1) % 3]));
  matrix_.size = static_cast<int>(D * n);
  matrix_.column_start.push_back(0);
  for (std::size_t v = 0; v < n; ++v) {
    auto& list = above[v];
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    const int first = static_cast<int>(D * v);
    for (int d = 0; d < D; ++d) {
      for (int e = d; e < D; ++e) matrix_.row.push_back(first + e);
      for (const int w : list)
        for (int e = 0; e < D; ++e) matrix_.row.push_back(D * w + e);
      matrix_.column_start.push_back(static_cast<int>(matrix_.row.size()));
    }
  }
  matrix_.value.assign(matrix_.row.size(), 0.0);

  const auto slot = [&](int v, int d, int w, int e) {  // v, d before w, e
    const int start = matrix_.column_start[D * v + d];
    if (v == w) return start + e - d;
    const auto& list = above[v];
    const auto at = std::lower_bound(list.begin(), list.end(), w) - list.begin();
    return start + D - d + D * static_cast<int>(at) + e;
  };
  slots_.resize(chart.triangles.size());
  for (std::size_t t = 0; t < slots_.size(); ++t)
    for (int i = 0, k = 0; i < 3 * D; ++i)
      for (int j = 0; j <= i; ++j) {
        const std::pair<int, int> a{chart.triangles[t][i / D], i % D}, b{chart.triangles[t][j / D], j % D};
        const auto [low, high] = std::minmax(a, b);
        slots_[t][k++] = slot(low.first, low.second, high.first, high.second);
      }
}

template <int D>
void ChartMatrix<D>::reset(double diagonal) {
  std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
  for (int c = 0; c < matrix_.size; ++c) matrix_.value[matrix_.column_start[c]] = diagonal;
}

}  // namespace vacuform
