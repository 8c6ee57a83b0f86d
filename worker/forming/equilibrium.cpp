#include "worker/forming/equilibrium.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Direction = Preconditioner::Direction;

double total(const Column& lanes) { return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]); }

}  // namespace

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
  free_membrane_.pack(membrane_, grid_, held);
  if (free_membrane_.free() == 0) return;
  constexpr int worth_a_factor = 12;  // iterations that take about as long as a new factorization
  if (fresh || !preconditioner_.factored() || worn_ >= worth_a_factor) {
    preconditioner_.factor(held, x);
    worn_ = 0;
  }
  preconditioner_.restrict_to(
      std::span(free_membrane_.vertices()).first(static_cast<std::size_t>(free_membrane_.free())), x);
}

template <class Work>
void Equilibrium::in_parts(const Work& work) const {
  const long n = free_membrane_.free();
  const auto run = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) work(k, n * k / parts, n * (k + 1) / parts);
  };
  constexpr int worth_threads = 4000;
  if (n < worth_threads)
    run(0, parts);
  else
    in_parallel(0, parts, run);
}

Equilibrium::Value Equilibrium::evaluate(const Pull& pull) {
  Value value;
  value.energy = free_membrane_.energy(x_, pull.pressure, trial_gradient_);
  std::array<Value, parts> sums;
  in_parts([&](int part, long begin, long end) {
    Value sum;
    Column slope = Column::Zero();
    double square = 0;
    for (long i = begin; i < end; ++i) {
      Column& g = trial_gradient_[i];
      if (pull.weight > 0) {
        const double force = pull.weight * rest_area_[free_membrane_.vertices()[i]];
        g[2] += force;
        sum.energy += force * x_[i][2];
      }
      slope += g * direction_[i].cast<double>();
      square = std::max(square, g.matrix().squaredNorm());
    }
    sum.slope = total(slope);
    sum.force = std::sqrt(square);
    sums[part] = sum;
  });
  for (const Value& sum : sums) {
    value.energy += sum.energy, value.slope += sum.slope;
    value.force = std::max(value.force, sum.force);
  }
  return value;
}

Equilibrium::Descent Equilibrium::choose_direction() {
  // H g = P g + s t - z w, with w = R^-1 s'g, t = R^-T ((D + y'z) w - z'g); R is the upper triangle of s'y, D its diagonal.
  const int m = pairs_;
  Eigen::Matrix<float, memory, 1> w = w.Zero(), t = t.Zero();
  if (m > 0) {
    const Eigen::MatrixXd R = sy_.topLeftCorner(m, m);
    const auto upper = R.triangularView<Eigen::Upper>();
    const Eigen::VectorXd of_z = upper.solve(sg_.head(m));
    Eigen::MatrixXd middle = zy_.topLeftCorner(m, m);
    middle += R.diagonal().asDiagonal();
    const Eigen::VectorXd of_s = upper.transpose().solve(middle * of_z - zg_.head(m));
    w.head(m) = of_z.cast<float>(), t.head(m) = of_s.cast<float>();
  }
  std::array<Descent, parts> sums;
  in_parts([&](int part, long begin, long end) {
    Column slope = Column::Zero();
    float square = 0;
    for (long i = begin; i < end; ++i) {
      Direction d = -preconditioned_[i];
      for (int k = 0; k < m; ++k) d += w[k] * z_[k][i] - t[k] * s_[k][i];
      direction_[i] = d;
      slope += gradient_[i] * d.cast<double>();
      square = std::max(square, d.matrix().squaredNorm());
    }
    sums[part] = {total(slope), std::sqrt(double(square))};
  });
  Descent descent;
  for (const Descent& sum : sums) {
    descent.slope += sum.slope;
    descent.longest = std::max(descent.longest, sum.longest);
  }
  return descent;
}

void Equilibrium::move(double step) {
  in_parts([&](int, long begin, long end) {
    for (long i = begin; i < end; ++i) x_[i] = base_[i] + step * direction_[i].cast<double>();
  });
}

void Equilibrium::remember(double step) {
  preconditioner_.apply(trial_gradient_, trial_preconditioned_);
  const int newest = pairs_;
  s_[newest].resize(direction_.size());
  z_[newest].resize(direction_.size());
  struct Sums {
    std::array<Column, memory + 1> sy, zy, sg, zg;
    Column ss = Column::Zero(), yy = Column::Zero();
  };
  std::array<Sums, parts> sums;
  in_parts([&](int part, long begin, long end) {
    Sums& sum = sums[part];
    for (auto* list : {&sum.sy, &sum.zy, &sum.sg, &sum.zg}) list->fill(Column::Zero());
    for (long i = begin; i < end; ++i) {
      s_[newest][i] = static_cast<float>(step) * direction_[i];
      z_[newest][i] = trial_preconditioned_[i] - preconditioned_[i];
      const Column g = trial_gradient_[i], y = g - gradient_[i];
      for (int k = 0; k <= newest; ++k) {
        const Column s = s_[k][i].cast<double>(), z = z_[k][i].cast<double>();
        sum.sy[k] += s * y, sum.zy[k] += z * y;
        sum.sg[k] += s * g, sum.zg[k] += z * g;
      }
      sum.ss += s_[newest][i].cast<double>().square();
      sum.yy += y.square();
    }
  });
  const auto add = [&](auto member, int k) {
    double sum = 0;
    for (const Sums& part : sums) sum += total((part.*member)[k]);
    return sum;
  };
  double ss = 0, yy = 0;
  for (const Sums& part : sums) ss += total(part.ss), yy += total(part.yy);
  for (int k = 0; k <= newest; ++k) {
    sy_(k, newest) = add(&Sums::sy, k);
    zy_(k, newest) = zy_(newest, k) = add(&Sums::zy, k);
    sg_[k] = add(&Sums::sg, k);
    zg_[k] = add(&Sums::zg, k);
  }
  gradient_.swap(trial_gradient_);
  preconditioned_.swap(trial_preconditioned_);

  if (!(sy_(newest, newest) > 1e-12 * std::sqrt(ss * yy))) return;
  ++pairs_;
  if (pairs_ <= memory) return;
  --pairs_;
  std::rotate(s_.begin(), s_.begin() + 1, s_.end());
  std::rotate(z_.begin(), z_.begin() + 1, z_.end());
  sy_.topLeftCorner<memory, memory>() =
      Eigen::Matrix<double, memory, memory>(sy_.bottomRightCorner<memory, memory>());
  zy_.topLeftCorner<memory, memory>() =
      Eigen::Matrix<double, memory, memory>(zy_.bottomRightCorner<memory, memory>());
  sg_.head<memory>() = Eigen::Matrix<double, memory, 1>(sg_.tail<memory>());
  zg_.head<memory>() = Eigen::Matrix<double, memory, 1>(zg_.tail<memory>());
}

double Equilibrium::moved() const {
  std::array<double, parts> squares{};
  in_parts([&](int part, long begin, long end) {
    for (long i = begin; i < end; ++i)
      squares[part] = std::max(squares[part], (base_[i] - start_[i]).matrix().squaredNorm());
  });
  return std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

Equilibrium::Outcome Equilibrium::solve(Points& x, const Pull& pull, const Limits& limits,
                                        const Context& context) {
  Outcome outcome;
  const auto n = static_cast<std::size_t>(free_membrane_.free());
  if (n == 0) {
    outcome.at_rest = true;
    return outcome;
  }
  const auto& vertices = free_membrane_.vertices();
  x_.resize(vertices.size());
  in_parallel(0, static_cast<int>(vertices.size()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) x_[i] << x.col(vertices[i]).array(), 0;
  });
  base_ = x_;
  const bool may_run_away = std::isfinite(limits.range);
  if (may_run_away) start_ = x_;
  direction_.assign(n, Direction::Zero());
  pairs_ = 0;
  Value now = evaluate(pull);
  gradient_.swap(trial_gradient_);
  if (now.force > limits.force) preconditioner_.apply(gradient_, preconditioned_);
  const auto result = [&]() -> const Outcome& {
    for (std::size_t i = 0; i < n; ++i) x.col(vertices[i]) = base_[i].head<3>();
    return outcome;
  };

  double taken = 0;  // the step of the last iteration
  int still = 0;     // iterations that hardly moved
  for (;; ++outcome.iterations, ++worn_) {
    outcome.residual = now.force;
    outcome.at_rest = outcome.residual <= limits.force || still >= 3;
    if (outcome.at_rest || outcome.iterations >= limits.iterations || context.cancelled()) return result();
    if (taken > 0) remember(taken);

    const Descent descent = choose_direction();
    taken = 0;
    if (!(descent.slope < 0)) {
      // The memory no longer gives a descent direction: discard it; the preconditioner always does.
      if (pairs_ == 0) return result();
      pairs_ = 0;
      continue;
    }
    double step = std::min(1.0, limits.stride / descent.longest);
    for (int shortening = 0; shortening < 30 && taken == 0; ++shortening) {
      move(step);
      const Value trial = evaluate(pull);
      const bool decrease = trial.energy <= now.energy + 1e-4 * step * descent.slope;
      // Near equilibrium the energies differ only by rounding: compare the slopes (Hager & Zhang 2005).
      const bool flat =
          trial.energy <= now.energy + 1e-13 * std::abs(now.energy) && trial.slope <= -0.99 * descent.slope;
      if (std::isfinite(trial.energy) && (decrease || flat)) {
        now = trial;
        taken = step;
      } else {
        // Where the slope vanishes if it is linear in between.
        const double zero = descent.slope / (descent.slope - trial.slope);
        step *= trial.slope > 0 && std::isfinite(trial.slope) ? std::clamp(zero, 0.1, 0.5) : 0.5;
      }
    }
    if (taken == 0) {
      if (pairs_ == 0) return result();
      pairs_ = 0;
      continue;
    }
    base_.swap(x_);
    still = taken * descent.longest <= limits.motion ? still + 1 : 0;
    if (may_run_away && moved() > limits.range) {
      outcome.ran_away = true;
      return result();
    }
  }
}

}  // namespace vacuform
