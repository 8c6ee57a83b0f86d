#include "worker/forming/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <stdexcept>

#include "worker/parallel.hpp"

namespace vacuform {

Equilibrium::Equilibrium(const Membrane& membrane, const std::vector<Triangle>& triangles,
                         std::vector<int> elimination_order)
    : membrane_(membrane), triangles_(triangles), order_(std::move(elimination_order)) {}

void Equilibrium::hold(const std::vector<char>& held, const Points& x) {
  free_.clear();
  index_.assign(held.size(), -1);
  for (std::size_t i = 0; i < held.size(); ++i)
    if (!held[i]) {
      index_[i] = static_cast<int>(free_.size());
      free_.push_back(static_cast<int>(i));
    }
  active_.clear();
  for (std::size_t k = 0; k < triangles_.size(); ++k)
    if (std::any_of(triangles_[k].begin(), triangles_[k].end(), [&](int v) { return !held[v]; }))
      active_.push_back(static_cast<int>(k));
  corner_start_.assign(free_.size() + 1, 0);
  for (const int k : active_)
    for (int v : triangles_[k])
      if (index_[v] >= 0) ++corner_start_[index_[v] + 1];
  std::partial_sum(corner_start_.begin(), corner_start_.end(), corner_start_.begin());
  corner_.resize(static_cast<std::size_t>(corner_start_.back()));
  std::vector<int> next(corner_start_.begin(), corner_start_.end() - 1);
  for (int n = 0; n < static_cast<int>(active_.size()); ++n)
    for (int c = 0; c < 3; ++c)
      if (const int row = index_[triangles_[active_[n]][c]]; row >= 0) corner_[next[row]++] = 3 * n + c;
  corners_.resize(active_.size());
  energies_.resize(active_.size());
  if (free_.empty()) return;

  struct Entry {
    int column, row;
    double value;
  };
  std::vector<Entry> entries;
  entries.reserve(active_.size() * 6);
  for (const int k : active_) {
    const Eigen::Vector3d c = membrane_.scalar_stiffness(x, k) * membrane_.rest_area(k);
    Eigen::Matrix2d T;
    T << c[0], c[1], c[1], c[2];
    const Eigen::Matrix3d K = membrane_.shape_gradient(k).transpose() * T * membrane_.shape_gradient(k);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const int row = index_[triangles_[k][a]], column = index_[triangles_[k][b]];
        if (column >= 0 && row >= column) entries.push_back({column, row, K(a, b)});
      }
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.column != b.column ? a.column < b.column : a.row < b.row;
  });
  SymmetricMatrix matrix;
  matrix.size = static_cast<int>(free_.size());
  matrix.column_start.assign(free_.size() + 1, 0);
  for (std::size_t n = 0; n < entries.size(); ++n) {
    const Entry& e = entries[n];
    if (n > 0 && entries[n - 1].column == e.column && entries[n - 1].row == e.row) {
      matrix.value.back() += e.value;
    } else {
      matrix.row.push_back(e.row);
      matrix.value.push_back(e.value);
      matrix.column_start[e.column + 1] = static_cast<int>(matrix.row.size());
    }
  }
  for (int c = 0; c < matrix.size; ++c)
    matrix.column_start[c + 1] = std::max(matrix.column_start[c + 1], matrix.column_start[c]);

  std::vector<int> order;
  for (const int v : order_)
    if (index_[v] >= 0) order.push_back(index_[v]);
  cholesky_.analyse(matrix, order);
  if (!cholesky_.factor(matrix))
    throw std::logic_error("the membrane's stand-in stiffness is not positive definite");
  rhs_.resize(matrix.size, 3);
}

double Equilibrium::energy(const Points& x, double p, Points& gradient) {
  // Each triangle writes its own place and each vertex gathers its own corners, in a fixed order: the sums are the
  // same on any number of threads.
  const auto triangles = [&](int begin, int end) {
    for (int n = begin; n < end; ++n) energies_[n] = membrane_.element_energy(x, p, active_[n], corners_[n]);
  };
  const auto vertices = [&](int begin, int end) {
    for (int r = begin; r < end; ++r) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int k = corner_start_[r]; k < corner_start_[r + 1]; ++k)
        sum += corners_[corner_[k] / 3].col(corner_[k] % 3);
      gradient.col(r) = sum;
    }
  };
  constexpr int worth_threads = 8000;
  const int n = static_cast<int>(active_.size()), m = static_cast<int>(free_.size());
  if (n < worth_threads) {
    triangles(0, n);
    vertices(0, m);
  } else {
    in_parallel(0, n, triangles);
    in_parallel(0, m, vertices);
  }
  return std::accumulate(energies_.begin(), energies_.end(), 0.0);
}

void Equilibrium::precondition(const Points& gradient, Points& direction) {
  rhs_ = gradient.transpose();
  cholesky_.solve(rhs_, solution_);
  direction = solution_.transpose();
}

Equilibrium::Outcome Equilibrium::solve(Points& x, double p, double tolerance, double cap, int iterations,
                                        const Context& context) {
  Outcome outcome;
  if (free_.empty()) {
    outcome.at_rest = true;
    return outcome;
  }
  constexpr std::size_t memory = 8;
  struct Pair {
    Points s, y;
    double rho;
  };
  std::deque<Pair> pairs;
  const Eigen::Index n = static_cast<Eigen::Index>(free_.size());
  Points f(3, n), trial(3, n), g(3, n), trial_g(3, n), q(3, n), d(3, n);  // over the free vertices
  const auto place = [&](const Points& at) {
    for (Eigen::Index r = 0; r < n; ++r) x.col(free_[r]) = at.col(r);
  };
  for (Eigen::Index r = 0; r < n; ++r) f.col(r) = x.col(free_[r]);
  const Points start = f;
  double e = energy(x, p, g);
  const auto largest = [](const Points& v) { return std::sqrt(v.colwise().squaredNorm().maxCoeff()); };

  for (;; ++outcome.iterations) {
    outcome.residual = largest(g);
    outcome.at_rest = outcome.residual <= tolerance;
    if (outcome.at_rest || outcome.iterations >= iterations || context.cancelled()) return outcome;

    q = g;
    std::vector<double> alpha(pairs.size());
    for (std::size_t k = pairs.size(); k-- > 0;) {
      alpha[k] = pairs[k].rho * pairs[k].s.cwiseProduct(q).sum();
      q -= alpha[k] * pairs[k].y;
    }
    precondition(q, d);
    for (std::size_t k = 0; k < pairs.size(); ++k)
      d += (alpha[k] - pairs[k].rho * pairs[k].y.cwiseProduct(d).sum()) * pairs[k].s;
    d = -d;
    const double slope = d.cwiseProduct(g).sum();
    if (!(slope <
          0)) {  // the memory no longer describes a descent: forget it, the preconditioner always does
      if (pairs.empty()) return outcome;
      pairs.clear();
      continue;
    }

    // No step leaves the ball of radius cap around the start.
    double step = 1;
    const double reach = largest(d);
    if (reach * step > cap) step = cap / reach;
    bool accepted = false;
    double trial_e = 0;
    for (int halving = 0; halving < 30; ++halving, step *= 0.5) {
      trial = f + step * d;
      place(trial);
      trial_e = energy(x, p, trial_g);
      const double rise = trial_g.cwiseProduct(d).sum();
      const bool decrease = trial_e <= e + 1e-4 * step * slope;
      // Near rest the energies differ by rounding alone: judge by the slopes (Hager & Zhang 2005).
      const bool flat = trial_e <= e + 1e-13 * std::abs(e) && rise <= -0.99 * slope;
      if (std::isfinite(trial_e) && (decrease || flat)) {
        accepted = true;
        break;
      }
    }
    if (!accepted) {
      place(f);
      if (pairs.empty()) return outcome;
      pairs.clear();
      continue;
    }
    Pair pair{trial - f, trial_g - g, 0};
    const double curvature = pair.s.cwiseProduct(pair.y).sum();
    if (curvature > 1e-12 * std::sqrt(pair.s.squaredNorm() * pair.y.squaredNorm())) {
      pair.rho = 1 / curvature;
      if (pairs.size() == memory) pairs.pop_front();
      pairs.push_back(std::move(pair));
    }
    f.swap(trial);
    g.swap(trial_g);
    e = trial_e;
    if (largest(f - start) >= 0.999 * cap) {
      outcome.capped = true;
      ++outcome.iterations;
      outcome.residual = largest(g);
      return outcome;
    }
  }
}

}  // namespace vacuform
