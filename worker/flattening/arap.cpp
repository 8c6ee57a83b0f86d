#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "worker/flattening/held_points.hpp"
#include "worker/flattening/methods.hpp"
#include "worker/numerics/supernodal_cholesky.hpp"

namespace vacuform {

namespace {

// The scale s of a triangle in the hybrid: the root of lambda s^3 + (1 - lambda) s = sum / 2, `sum` the singular values'.
// It is the only positive one; the cubic is convex there, so that Newton's steps from above stay above.
double hybrid_scale(double lambda, double sum) {
  double s = std::max(1.0, sum / 2);
  for (int i = 0; i < 50; ++i) {
    const double step = (lambda * s * s * s + (1 - lambda) * s - sum / 2) / (3 * lambda * s * s + 1 - lambda);
    s -= step;
    if (std::abs(step) < 1e-14 * s) break;
  }
  return s;
}

class LocalGlobal {
 public:
  LocalGlobal(Chart& chart, std::optional<double> lambda)
      : chart_(chart),
        lambda_(lambda),
        elements_(elements(chart)),
        pins_(held_points(chart)),
        stiffness_(stiffness_of_pins(chart)),
        matrix_(laplacian()),
        cholesky_(matrix_.matrix()) {
    if (!cholesky_.factor(matrix_.matrix()))
      throw std::logic_error("the cotangent Laplacian is not positive definite");
  }

  double area() const {
    double sum = 0;
    for (const ChartElement& e : elements_) sum += e.area;
    return sum;
  }

  // Finds each triangle's best rotation (and scale); the energy of the chart as it is, and rhs_ for the step.
  double local() {
    rhs_.setZero(static_cast<Eigen::Index>(chart_.uv.size()), 2);
    double energy = 0;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      const Eigen::Matrix2d J = jacobian(chart_, elements_, k);
      const double c = J(0, 0) + J(1, 1), s = J(1, 0) - J(0, 1), sum = std::sqrt(c * c + s * s);
      const double scale = lambda_ ? hybrid_scale(*lambda_, sum) : 1, part = sum > 0 ? scale / sum : 0;
      Eigen::Matrix2d R;
      R << part * c, -part * s, part * s, part * c;
      if (sum == 0) R = scale * Eigen::Matrix2d::Identity();
      const double weight = chart_.weight_of(k) * elements_[k].area, excess = scale * scale - 1;
      energy += weight * (J.squaredNorm() - 2 * scale * sum + 2 * scale * scale +
                          lambda_.value_or(0) * excess * excess);
      const Eigen::Matrix<double, 3, 2> pull = weight * elements_[k].gradient * R.transpose();
      for (int i = 0; i < 3; ++i) rhs_.row(chart_.triangles[k][i]) += pull.row(i);
    }
    for (const ChartPin& pin : pins_) {
      energy += stiffness_ * (place_of(chart_, pin) - pin.target).squaredNorm();
      for (int i = 0; i < 3; ++i)
        rhs_.row(chart_.triangles[pin.triangle][i]) += stiffness_ * pin.corners[i] * pin.target.transpose();
    }
    return energy;
  }

  // The best places for these rotations.
  void global() {
    cholesky_.solve(rhs_);
    for (std::size_t i = 0; i < chart_.uv.size(); ++i) chart_.uv[i] = rhs_.row(static_cast<Eigen::Index>(i));
  }

 private:
  ChartMatrix<1> laplacian() const {
    ChartMatrix<1> L(chart_);
    L.reset(1e-12);  // for a vertex without weight
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      const auto& G = elements_[k].gradient;
      L.add(k, chart_.weight_of(k) * elements_[k].area * G * G.transpose());
    }
    add_pins(L, pins_, stiffness_);
    return L;
  }

  Chart& chart_;
  std::optional<double> lambda_;
  std::vector<ChartElement> elements_;
  std::vector<ChartPin> pins_;
  double stiffness_;
  ChartMatrix<1> matrix_;
  SupernodalCholesky cholesky_;
  SupernodalCholesky::Columns<2> rhs_;
};

// Tells when an energy that falls step by step has little left to fall: the sum of all that would follow if its gains
// kept shrinking as in the last two steps, or in the slower of them.
class Settling {
 public:
  // An energy no larger than `nothing` has settled too.
  Settling(double energy, double nothing) : energy_(energy), nothing_(nothing) {}

  bool after(double energy) {
    constexpr double little = 1e-6, rounding = 1e-13, never = std::numeric_limits<double>::infinity();
    const double gain = energy_ - energy, ratio = gain_ > 0 ? gain / gain_ : never;
    const double slower = std::max(ratio, ratio_);
    energy_ = energy, gain_ = gain, ratio_ = ratio;
    if (energy <= nothing_ || gain <= rounding * energy) return true;
    return slower < 1 && gain * slower / (1 - slower) <= little * energy;
  }

 private:
  double energy_, nothing_;
  double gain_ = 0, ratio_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Result<FlatteningOutcome> flatten_arap(Chart& chart, const Context& context, std::optional<double> lambda,
                                       int most_iterations) {
  VACUFORM_CHECK(context.step(Stage::flattening, 0));
  LocalGlobal steps(chart, lambda);
  FlatteningOutcome outcome;
  constexpr double least_strain_squared = 1e-14;
  Settling settling(steps.local(), least_strain_squared * steps.area());
  while (outcome.iterations < most_iterations && !outcome.converged) {
    VACUFORM_CHECK(context.step(Stage::flattening, 1 - 1 / (1 + 0.1 * outcome.iterations)));
    steps.global();
    ++outcome.iterations;
    outcome.converged = settling.after(steps.local());
  }
  return outcome;
}

}  // namespace vacuform
