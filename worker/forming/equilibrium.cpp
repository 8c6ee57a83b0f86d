#include "worker/forming/equilibrium.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numeric>
#include <stdexcept>

#include "worker/stage/parallel.hpp"

namespace vacuform {

Equilibrium::Equilibrium(const Membrane& membrane, const SheetGrid& grid)
    : membrane_(membrane), grid_(grid), preconditioner_(membrane, grid) {
  weigh();
}

void Equilibrium::weigh() {
  rest_area_.assign(grid_.rest.size(), 0);
  for (std::size_t k = 0; k < grid_.triangles.size(); ++k)
    for (int v : grid_.triangles[k]) rest_area_[v] += membrane_.rest_area(static_cast<int>(k)) / 3;
}

void Equilibrium::hold(const std::vector<char>& held, const Points& x, bool fresh) {
  free_.clear();
  index_.assign(held.size(), -1);
  for (std::size_t i = 0; i < held.size(); ++i)
    if (!held[i]) {
      index_[i] = static_cast<int>(free_.size());
      free_.push_back(static_cast<int>(i));
    }
  active_.clear();
  for (std::size_t k = 0; k < grid_.triangles.size(); ++k)
    if (std::any_of(grid_.triangles[k].begin(), grid_.triangles[k].end(), [&](int v) { return !held[v]; }))
      active_.push_back(static_cast<int>(k));
  middle_ = static_cast<int>(active_.size()) / 2;
  if (free_.empty()) return;
  constexpr int worth_a_factor = 25;  // iterations that take about as long as a new factorization
  if (fresh || !preconditioner_.factored() || worn_ >= worth_a_factor) {
    preconditioner_.factor(held, x);
    worn_ = 0;
  }
  preconditioner_.restrict_to(free_, x);
}

double Equilibrium::energy(const Points& x, const Pull& pull, Points& gradient) {
  // Two halves of the triangles, each summed in order: the sums are the same for any number of threads.
  const Eigen::Index n = static_cast<Eigen::Index>(free_.size());
  std::array<double, 2> energies{};
  const auto sum = [&](int half) {
    Points& into = halves_[half];
    into.setZero(3, n + 1);  // the last column collects the held vertices
    const int end = half == 0 ? middle_ : static_cast<int>(active_.size());
    double total = 0;
    const auto add = [&](int triangle, const Eigen::Matrix3d& corners) {
      const Triangle& t = grid_.triangles[triangle];
      for (int c = 0; c < 3; ++c) into.col(index_[t[c]] < 0 ? n : index_[t[c]]) += corners.col(c);
    };
    std::array<Eigen::Matrix3d, 4> corners;
    int k = half == 0 ? 0 : middle_;
    for (; k + 4 <= end; k += 4) {
      total += membrane_.element_energies(x, pull.pressure, std::span<const int, 4>(&active_[k], 4),
                                          corners.data());
      for (int lane = 0; lane < 4; ++lane) add(active_[k + lane], corners[lane]);
    }
    for (; k < end; ++k) {
      total += membrane_.element_energy(x, pull.pressure, active_[k], corners[0]);
      add(active_[k], corners[0]);
    }
    energies[half] = total;
  };
  constexpr std::size_t worth_threads = 8000;
  if (active_.size() < worth_threads)
    sum(0), sum(1);
  else
    in_parallel(0, 2, [&](int begin, int end) {
      for (int half = begin; half < end; ++half) sum(half);
    });
  gradient = halves_[0].leftCols(n) + halves_[1].leftCols(n);
  double weight = 0;
  if (pull.weight > 0)
    for (Eigen::Index r = 0; r < n; ++r) {
      const double force = pull.weight * rest_area_[free_[r]];
      gradient(2, r) += force;
      weight += force * x(2, free_[r]);
    }
  return energies[0] + energies[1] + weight;
}

Equilibrium::Outcome Equilibrium::solve(Points& x, const Pull& pull, const Limits& limits,
                                        const Context& context) {
  Outcome outcome;
  if (free_.empty()) {
    outcome.at_rest = true;
    return outcome;
  }
  constexpr std::size_t memory = 5;
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
  double e = energy(x, pull, g);
  const auto largest = [](const Points& v) { return std::sqrt(v.colwise().squaredNorm().maxCoeff()); };

  int still = 0;  // iterations that hardly moved
  for (;; ++outcome.iterations, ++worn_) {
    outcome.residual = largest(g);
    outcome.at_rest = outcome.residual <= limits.force || still >= 3;
    if (outcome.at_rest || outcome.iterations >= limits.iterations || context.cancelled()) return outcome;

    q = g;
    std::vector<double> alpha(pairs.size());
    for (std::size_t k = pairs.size(); k-- > 0;) {
      alpha[k] = pairs[k].rho * pairs[k].s.cwiseProduct(q).sum();
      q -= alpha[k] * pairs[k].y;
    }
    preconditioner_.apply(q, d);
    for (std::size_t k = 0; k < pairs.size(); ++k)
      d += (alpha[k] - pairs[k].rho * pairs[k].y.cwiseProduct(d).sum()) * pairs[k].s;
    d = -d;
    const double slope = d.cwiseProduct(g).sum();
    if (!(slope <
          0)) {  // the memory no longer gives a descent direction: discard it; the preconditioner always does
      if (pairs.empty()) return outcome;
      pairs.clear();
      continue;
    }

    double step = std::min(1.0, limits.stride / largest(d));
    bool accepted = false;
    double trial_e = 0;
    for (int halving = 0; halving < 30; ++halving, step *= 0.5) {
      trial = f + step * d;
      place(trial);
      trial_e = energy(x, pull, trial_g);
      const double rise = trial_g.cwiseProduct(d).sum();
      const bool decrease = trial_e <= e + 1e-4 * step * slope;
      // Near equilibrium the energies differ only by rounding: compare the slopes (Hager & Zhang 2005).
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
    still = largest(pair.s) <= limits.motion ? still + 1 : 0;
    const double curvature = pair.s.cwiseProduct(pair.y).sum();
    if (curvature > 1e-12 * std::sqrt(pair.s.squaredNorm() * pair.y.squaredNorm())) {
      pair.rho = 1 / curvature;
      if (pairs.size() == memory) pairs.pop_front();
      pairs.push_back(std::move(pair));
    }
    f.swap(trial);
    g.swap(trial_g);
    e = trial_e;
    if (largest(f - start) > limits.range) {
      outcome.ran_away = true;
      return outcome;
    }
  }
}

}  // namespace vacuform
