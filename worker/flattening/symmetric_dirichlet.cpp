#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "worker/flattening/embedding.hpp"
#include "worker/flattening/held_points.hpp"
#include "worker/flattening/methods.hpp"
#include "worker/flattening/outside.hpp"
#include "worker/flattening/symmetric_dirichlet_energy.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/numerics/supernodal_cholesky.hpp"
#include "worker/stage/sub_progress.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {

class ProjectedNewton {
 public:
  ProjectedNewton(Chart& chart, std::vector<ChartElement> shapes)
      : chart_(chart),
        elements_(std::move(shapes)),
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
    for (double shift = 1e-9; !cholesky_.factor(matrix_.matrix()); shift *= 100) {
      if (!(shift < 1)) throw std::logic_error("the projected Hessian is not positive definite");
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
      const double area = cross(a, b), bend = cross(da, db);
      const double middle = a.x() * db.y() - a.y() * db.x() + da.x() * b.y() - da.y() * b.x();
      least = std::min(least, first_root(area, middle, bend));
    }
    constexpr double margin = 0.9;
    return std::min(1.0, margin * least);
  }

  // Takes as much of the step as lowers the energy: whether any does.
  bool take(double expected) {
    const std::vector<Eigen::Vector2d> from = chart_.uv;
    const double before = energy();
    constexpr double armijo = 1e-4, least_part = 1e-12;
    for (double part = longest(); part > least_part; part /= 2) {
      for (std::size_t i = 0; i < from.size(); ++i) chart_.uv[i] = from[i] + part * move(static_cast<int>(i));
      if (energy() <= before - armijo * part * 2 * expected) return true;
    }
    chart_.uv = from;
    return false;
  }

  // A whole step: whether it was the last.
  bool settled() {
    constexpr double least_gain = 1e-6;
    const double before = energy(), expected = find_step();
    return !take(expected) || expected <= least_gain * before;
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
    // Entries are about 1 whatever the grid. The chart's turn, which costs nothing, needs a little to hold on to.
    matrix_.reset(1e-9);
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
  VACUFORM_CHECK(flatten_arap(warm, context, {}, iterations));
  const ChartQuality before = chart_quality(chart), after = chart_quality(warm);
  if (after.flipped == 0 && after.symmetric_dirichlet < before.symmetric_dirichlet)
    chart.uv = std::move(warm.uv);
  return {};
}

// The chart with the plane around it out to a circle that stays where it is, as triangles whose own shape is the one they
// have now and which count little: they give way, and turn over no more than the chart's do.
struct Surrounded {
  Chart chart;
  std::vector<ChartElement> shapes;
};
Surrounded surround(const Chart& chart, const std::vector<ChartElement>& shapes,
                    const std::vector<std::vector<int>>& loops) {
  constexpr int points = 48;
  constexpr double share = 0.01;  // of the chart's own weight
  Surrounded out{chart, shapes};
  Eigen::Vector2d low = chart.uv[0], high = low;
  for (const auto& p : chart.uv) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::vector<int> circle;
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * i / points;
    circle.push_back(static_cast<int>(out.chart.uv.size()));
    out.chart.uv.push_back((low + high) / 2 +
                           (high - low).norm() * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  Chart plane;
  plane.uv = out.chart.uv;
  plane.triangles = triangles_outside(plane.uv, loops, circle);
  for (const auto& p : plane.uv) plane.inked.emplace_back(p.x(), p.y(), 0);
  const std::vector<ChartElement> outside = elements(plane);

  double inner = 0, outer = 0;
  for (std::size_t k = 0; k < shapes.size(); ++k) inner += chart.weight_of(k) * shapes[k].area;
  for (const ChartElement& e : outside) outer += e.area;
  out.chart.weight.resize(shapes.size(), 1);
  out.chart.weight.resize(shapes.size() + outside.size(), share * inner / outer);
  out.shapes.insert(out.shapes.end(), outside.begin(), outside.end());
  for (const Triangle& t : plane.triangles) {
    for (int c = 0; c < 3; ++c)
      if (t[c] >= static_cast<int>(chart.uv.size()))
        out.chart.pins.push_back(
            {static_cast<int>(out.chart.triangles.size()), Eigen::Vector3d::Unit(c), plane.uv[t[c]]});
    out.chart.triangles.push_back(t);
  }
  return out;
}

using Steps = std::function<bool()>;  // one step: whether it was the last
Result<FlatteningOutcome> until_settled(const Steps& step, int most_iterations, const Context& context) {
  FlatteningOutcome outcome;
  while (outcome.iterations < most_iterations && !outcome.converged) {
    VACUFORM_CHECK(context.step(Stage::flattening, 1 - 1 / (1 + 0.3 * outcome.iterations)));
    outcome.converged = step();
    ++outcome.iterations;
  }
  return outcome;
}

// Nothing turned over and nothing covered twice.
bool injective(const Chart& chart) {
  return chart_quality(chart).flipped == 0 && border_crossings(chart) == 0;
}

}  // namespace

Result<FlatteningOutcome> flatten_symmetric_dirichlet(Chart& chart, const Context& context) {
  if (!injective(chart) && (!embed_on_disk(chart) || !injective(chart)))
    return fail(Code::unusable_surface, "the region has no start without triangles turned over",
                "flattening.method", "use flattening.method = arap");
  if (!chart.pins.empty()) move_onto_pins(chart.uv, chart.triangles, chart.pins);
  const std::vector<Eigen::Vector2d> start = chart.uv;
  const SubProgress first(context, {Stage::flattening, 0, 0.3}),
      second(context, {Stage::flattening, 0.3, 0.8}), third(context, {Stage::flattening, 0.8, 1});
  VACUFORM_CHECK(start_from_arap(chart, first.context()));
  const std::vector<ChartElement> shapes = elements(chart);
  ProjectedNewton newton(chart, shapes);
  VACUFORM_TRY(free, until_settled([&] { return newton.settled(); }, 200, second.context()));
  if (border_crossings(chart) == 0) return free;

  // Free, its border ran over itself: once more, within the plane around it.
  chart.uv = start;
  const auto loops = border_loops(chart.triangles);
  const auto step = [&] {
    Surrounded around = surround(chart, shapes, loops);
    const bool settled = ProjectedNewton(around.chart, around.shapes).settled();
    std::copy_n(around.chart.uv.begin(), chart.uv.size(), chart.uv.begin());
    return settled;
  };
  VACUFORM_TRY(held, until_settled(step, 200, third.context()));
  held.iterations += free.iterations;
  return held;
}

}  // namespace vacuform
