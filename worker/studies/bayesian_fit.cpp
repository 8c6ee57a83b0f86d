#include "worker/studies/bayesian_fit.hpp"

#include <algorithm>
#include <cmath>

#include "worker/numerics/box_minimum.hpp"
#include "worker/numerics/dense.hpp"
#include "worker/numerics/rigid_fit.hpp"

namespace vacuform {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double huber = 3.5;  // times the noise: a larger distance counts linearly
constexpr double median_length =
    1.538;                      // of a normal error in three coordinates, in standard deviations of one
constexpr double reach = 1.25;  // of the design, in half widths
constexpr double still = 1e-5;  // of the prior's standard deviation: smaller steps end the search
constexpr int most_steps = 200;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Removes from each column what a rigid motion of the points can do, by weighted least squares.
void project_motion_out(MatrixXd& columns, const std::vector<Vector3d>& at, const VectorXd& weights) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : at) centre += p / static_cast<double>(at.size());
  MatrixXd motion(columns.rows(), 6);
  for (std::size_t i = 0; i < at.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const Index row = 3 * static_cast<Index>(i);
      motion.block<3, 1>(row, k) = Vector3d::Unit(k);
      motion.block<3, 1>(row, 3 + k) = Vector3d::Unit(k).cross(at[i] - centre) / 100;
    }
  const MatrixXd weighted = weights.asDiagonal() * motion;
  columns -= motion * solve_symmetric(MatrixXd(weighted.transpose() * motion),
                                      MatrixXd(weighted.transpose() * columns));
}

// The nearest symmetric matrix without negative eigenvalues.
MatrixXd positive(const MatrixXd& m) {
  const SymmetricEigen eigen = symmetric_eigen(m);
  return eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
}

// What the points tell about the step from t, in units of the prior's standard deviations.
struct Knowledge {
  MatrixXd information, without_error;
  VectorXd pull;  // information times the step that the points alone ask for
};

Knowledge knowledge(const FitProblem& p, const ResponseSurface& surface, const Laid& laid,
                    const VectorXd& residual, double variance) {
  const Index n = p.centre.size();
  VectorXd weights(residual.size());
  std::vector<Vector3d> at;
  for (std::size_t i = 0; i < p.measured.size(); ++i) {
    weights.segment<3>(3 * static_cast<Index>(i)).setConstant(laid.weights[i]);
    at.push_back(laid.motion * p.measured[i]);
  }
  const VectorXd scale = p.prior_sd.cwiseQuotient(p.half_width);
  MatrixXd columns(residual.size(), n + surface.errors().cols());
  columns << surface.mean_slopes() * scale.asDiagonal(), surface.errors();
  if (!p.registered) project_motion_out(columns, at, weights);
  const MatrixXd jacobian = columns.leftCols(n), weighted = weights.asDiagonal() * jacobian;
  const MatrixXd by_chance = scale.asDiagonal() * surface.slope_covariance() * scale.asDiagonal() *
                             weights.dot(surface.slope_scatter());
  const MatrixXd a = positive(jacobian.transpose() * weighted - by_chance);
  const MatrixXd error = weighted.transpose() * columns.rightCols(surface.errors().cols());
  MatrixXd m = variance * a + error * error.transpose();
  m.diagonal().array() += 1e-12 * m.trace();
  return {a * solve_symmetric(m, a), a / variance,
          a * solve_symmetric(m, VectorXd(weighted.transpose() * residual))};
}

}  // namespace

Laid lay_points(const FitProblem& problem, const VectorXd& places) {
  Laid out;
  const std::size_t n = problem.measured.size();
  std::vector<Vector3d> formed;
  for (std::size_t i = 0; i < n; ++i) formed.push_back(places.segment<3>(3 * static_cast<Index>(i)));
  out.weights.assign(n, 1);
  for (int round = 0; round < 10; ++round) {  // the motion and the weights depend on each other
    if (!problem.registered) out.motion = rigid_motion(problem.measured, formed, out.weights);
    out.lengths.clear();
    for (std::size_t i = 0; i < n; ++i)
      out.lengths.push_back((out.motion * problem.measured[i] - formed[i]).norm());
    const double beyond = huber * std::max(1e-6, median(out.lengths) / median_length);
    for (std::size_t i = 0; i < n; ++i)
      out.weights[i] = out.lengths[i] <= beyond ? 1 : beyond / out.lengths[i];
  }
  return out;
}

BayesianFit bayesian_fit(const FitProblem& p, const ResponseSurface& surface) {
  const Index n = p.centre.size();
  const VectorXd low = p.low.cwiseMax(p.centre - reach * p.half_width),
                 high = p.high.cwiseMin(p.centre + reach * p.half_width);
  const double freedom =
      std::max(1.0, 3.0 * static_cast<double>(p.measured.size()) - double(n) - (p.registered ? 0 : 6));
  BayesianFit out;
  out.t = p.prior_mean.cwiseMax(low).cwiseMin(high);
  VectorXd last = VectorXd::Zero(n);
  double pace = 1;  // halved where the steps turn back: the weights and the slopes change on the way
  for (int step = 0; step < most_steps && !out.converged; ++step) {
    const VectorXd u = (out.t - p.centre).cwiseQuotient(p.half_width), places = surface.value(u);
    const Laid laid = lay_points(p, places);
    VectorXd residual(places.size());
    double sum = 0;
    for (std::size_t i = 0; i < p.measured.size(); ++i) {
      const Index row = 3 * static_cast<Index>(i);
      residual.segment<3>(row) = laid.motion * p.measured[i] - places.segment<3>(row);
      sum += std::pow(laid.weights[i] * laid.lengths[i], 2);
    }
    const double variance = std::max(1e-12, sum / freedom);
    const Knowledge points = knowledge(p, surface, laid, residual, variance);
    const MatrixXd identity = MatrixXd::Identity(n, n), whole = points.information + identity;
    const VectorXd move =
        box_minimum(whole, points.pull + (p.prior_mean - out.t).cwiseQuotient(p.prior_sd),
                    (low - out.t).cwiseQuotient(p.prior_sd), (high - out.t).cwiseQuotient(p.prior_sd));
    out.converged = move.cwiseAbs().maxCoeff() < still;
    if (move.dot(last) < 0) pace = std::max(0.05, pace / 2);
    last = move;
    out.t = (out.t + p.prior_sd.cwiseProduct(pace * move)).cwiseMax(low).cwiseMin(high);

    const auto sd = p.prior_sd.asDiagonal();
    const MatrixXd covariance = solve_symmetric(whole, identity),
                   noise_alone = solve_symmetric(MatrixXd(points.without_error + identity), identity);
    out.information = sd.inverse() * points.information * sd.inverse();
    out.covariance = sd * covariance * sd;
    out.freedom.resize(n);
    for (Index k = 0; k < n; ++k) {  // by Welch and Satterthwaite
      const double share = std::max(0.0, 1 - noise_alone(k, k) / covariance(k, k));
      out.freedom[k] = 1 / (share * share / surface.freedom() + (1 - share) * (1 - share) / freedom);
    }
    out.noise_mm = std::sqrt(variance);
    out.motion = laid.motion, out.weights = laid.weights;
  }
  return out;
}

double interval_95(double freedom) {
  const double z = 1.959964;
  return z + (std::pow(z, 3) + z) / (4 * freedom) +
         (5 * std::pow(z, 5) + 16 * std::pow(z, 3) + 3 * z) / (96 * freedom * freedom);
}

}  // namespace vacuform
