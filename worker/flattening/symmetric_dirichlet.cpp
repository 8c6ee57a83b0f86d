#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/flattening/embedding.hpp"
#include "worker/flattening/held_points.hpp"
#include "worker/flattening/methods.hpp"
#include "worker/flattening/supernodal_cholesky.hpp"
#include "worker/flattening/symmetric_dirichlet_energy.hpp"
#include "worker/portion.hpp"

namespace vacuform {

namespace {

class ProjectedNewton {
 public:
  explicit ProjectedNewton(Chart& chart)
      : chart_(chart),
        elements_(elements(chart)),
        pins_(held_points(chart)),
        stiffness_(stiffness_of_pins(chart)),
        matrix_(chart),
        cholesky_(matrix_.matrix(), 2),
        step_(static_cast<Eigen::Index>(2 * chart.uv.size())) {}

  // Infinite where a triangle is turned over.
  double energy() const {
    double sum = 0;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      sum += chart_.weight_of(k) * elements_[k].area * symmetric_dirichlet(jacobian(chart_, elements_, k));
    for (const ChartPin& pin : pins_) sum += stiffness_ * (place_of(chart_, pin) - pin.target).squaredNorm();
    return sum;
  }

  // Finds the step that the projected Hessian gives; how much half of it is expected to lower the energy.
  double find_step() {
    assemble();
    for (double shift = 1e-9;; shift *= 100) {
      if (cholesky_.factor(matrix_.matrix())) break;
      matrix_.shift_diagonal(shift * largest_);
    }
    const Eigen::VectorXd gradient = step_;
    cholesky_.solve(step_);
    step_ = -step_;
    return -gradient.dot(step_) / 2;
  }

  // The longest part of the step, of at most 1, that leaves every triangle on its side.
  double longest() const {
    double least = std::numeric_limits<double>::infinity();
    for (const Triangle& t : chart_.triangles) {
      const Eigen::Vector2d a = chart_.uv[t[1]] - chart_.uv[t[0]], b = chart_.uv[t[2]] - chart_.uv[t[0]];
      const Eigen::Vector2d da = move(t[1]) - move(t[0]), db = move(t[2]) - move(t[0]);
      // Twice the area along the step: area + middle x + bend x^2, positive at 0.
      const double area = a.x() * b.y() - a.y() * b.x(), bend = da.x() * db.y() - da.y() * db.x();
      const double middle = a.x() * db.y() - a.y() * db.x() + da.x() * b.y() - da.y() * b.x();
      least = std::min(least, first_root(area, middle, bend));
    }
    constexpr double margin = 0.9;
    return std::min(1.0, margin * least);
  }

  // Takes as much of the step as lowers the energy; 0 when none does.
  double take(double energy_now, double expected, double& energy_then) {
    const std::vector<Eigen::Vector2d> from = chart_.uv;
    constexpr double armijo = 1e-4;
    for (double part = longest(); part > 1e-12; part /= 2) {
      for (std::size_t i = 0; i < from.size(); ++i) chart_.uv[i] = from[i] + part * move(static_cast<int>(i));
      energy_then = energy();
      if (energy_then <= energy_now - armijo * part * 2 * expected) return part;
    }
    chart_.uv = from;
    energy_then = energy_now;
    return 0;
  }

 private:
  Eigen::Vector2d move(int vertex) const { return {step_[2 * vertex], step_[2 * vertex + 1]}; }

  // The first positive x at which c + b x + a x^2 vanishes, for c > 0; infinite without any.
  static double first_root(double c, double b, double a) {
    const double inside = b * b - 4 * a * c;
    if (inside < 0) return std::numeric_limits<double>::infinity();
    const double root = std::sqrt(inside);
    if (b < 0) return 2 * c / (-b + root);
    return a < 0 ? (-b - root) / (2 * a) : std::numeric_limits<double>::infinity();
  }

  // The projected Hessian into matrix_, the gradient into step_.
  void assemble() {
    matrix_.reset(0);
    step_.setZero();
    largest_ = 0;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      const auto& G = elements_[k].gradient;
      const double weight = chart_.weight_of(k) * elements_[k].area;
      const SymmetricDirichlet e = symmetric_dirichlet_expansion(jacobian(chart_, elements_, k));
      // How the corners' coordinates move J: dJ = [du0 du1 du2] G.
      const Eigen::Matrix<double, 2, 3> force = weight * e.gradient * G.transpose();
      for (int i = 0; i < 3; ++i) step_.segment<2>(2 * chart_.triangles[k][i]) += force.col(i);
      Eigen::Matrix<double, 6, 4> pulled;
      for (int m = 0; m < 4; ++m) {
        const Eigen::Matrix2d direction = e.directions.col(m).reshaped(2, 2);
        const Eigen::Matrix<double, 2, 3> moved =
            std::sqrt(weight * e.eigenvalues[m]) * direction * G.transpose();
        pulled.col(m) = moved.reshaped();
      }
      const Eigen::Matrix<double, 6, 6> H = pulled * pulled.transpose();
      largest_ = std::max(largest_, H.diagonal().maxCoeff());
      matrix_.add(k, H);
    }
    for (const ChartPin& pin : pins_) {
      const Eigen::Vector2d pull = 2 * stiffness_ * (place_of(chart_, pin) - pin.target);
      for (int i = 0; i < 3; ++i)
        step_.segment<2>(2 * chart_.triangles[pin.triangle][i]) += pin.corners[i] * pull;
    }
    add_pins(matrix_, pins_, 2 * stiffness_);
  }

  Chart& chart_;
  std::vector<ChartElement> elements_;
  std::vector<ChartPin> pins_;
  double stiffness_;
  ChartMatrix<2> matrix_;
  SupernodalCholesky cholesky_;
  Eigen::VectorXd step_;  // the gradient, then the step: 2 v and 2 v + 1 are vertex v's
  double largest_ = 0;
};

// A few iterations of ARAP are most of the way, where they turn nothing over.
Result<void> start_from_arap(Chart& chart, const Context& context) {
  constexpr int iterations = 10;
  Chart warm = chart;
  const Portion part(context, Stage::flattening, 0, 0.3);
  VACUFORM_CHECK(flatten_arap(warm, part.context(), {}, iterations));
  const ChartQuality before = chart_quality(chart), after = chart_quality(warm);
  if (after.flipped == 0 && after.symmetric_dirichlet < before.symmetric_dirichlet)
    chart.uv = std::move(warm.uv);
  return {};
}

}  // namespace

Result<FlatteningOutcome> flatten_symmetric_dirichlet(Chart& chart, const Context& context) {
  constexpr int most_iterations = 200;
  constexpr double least_gain = 1e-6;
  if (chart_quality(chart).flipped > 0 && (!embed_on_disk(chart) || chart_quality(chart).flipped > 0))
    return fail(Code::unusable_surface, "the region has no start without triangles turned over",
                "flattening.method", "use flattening.method = arap");
  if (!chart.pins.empty()) move_onto_pins(chart.uv, chart.triangles, chart.pins);
  VACUFORM_CHECK(start_from_arap(chart, context));
  ProjectedNewton newton(chart);
  FlatteningOutcome outcome;
  double energy = newton.energy();
  while (outcome.iterations < most_iterations && !outcome.converged) {
    VACUFORM_CHECK(context.step(Stage::flattening, 1 - 1 / (1.5 + 0.3 * outcome.iterations)));
    const double expected = newton.find_step();
    const double before = energy;
    const double part = newton.take(before, expected, energy);
    ++outcome.iterations;
    outcome.converged = expected <= least_gain * before || part == 0;
  }
  return outcome;
}

}  // namespace vacuform
