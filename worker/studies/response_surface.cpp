#include "worker/studies/response_surface.hpp"

#include <array>
#include <cmath>

#include "worker/numerics/dense.hpp"

namespace vacuform {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double corner = 0.7;  // half side of the cube of corners
constexpr std::array<double, 4> axis_spacing{1.9, 1.6, 2.1, 1.7}, corner_spacing{2.0, 1.55, 1.8, 1.65};
constexpr std::array<double, 5> centre_spacing{0.8, 0.9, 1.0, 1.15, 1.35};

// The trend is linear in the square of the spacing, the order that bench_exact and bench_calibration observe.
constexpr double to_no_spacing = -1, order_unknown = 0.25;

MatrixXd inverse_normal(const MatrixXd& x) {
  return solve_symmetric(MatrixXd(x.transpose() * x), MatrixXd(MatrixXd::Identity(x.cols(), x.cols())));
}

}  // namespace

std::vector<DesignPoint> central_composite(int parameters) {
  std::vector<DesignPoint> out;
  const auto pair = [&](const VectorXd& u, double spacing) {
    out.push_back({u, spacing});
    out.push_back({-u, spacing});
  };
  for (int k = 0; k < parameters; ++k) pair(VectorXd::Unit(parameters, k), axis_spacing[k]);
  for (int c = 0; c < 4; ++c) {
    const double a = c & 1 ? 1 : -1, b = c & 2 ? 1 : -1;
    VectorXd u(parameters);
    u.head(3) << 1, a, b;
    if (parameters == 4) u[3] = a * b;
    pair(corner * u, corner_spacing[c]);
  }
  for (const double spacing : centre_spacing) out.push_back({VectorXd::Zero(parameters), spacing});
  return out;
}

ResponseSurface::ResponseSurface(const std::vector<DesignPoint>& design, const MatrixXd& outputs) {
  const Index n = design.front().u.size(), centres = static_cast<Index>(centre_spacing.size()),
              pairs = (static_cast<Index>(design.size()) - centres) / 2, grids = pairs + centres;
  MatrixXd odd(pairs, n), even(grids, n + 2), odd_y(pairs, outputs.cols()), even_y(grids, outputs.cols());
  for (Index g = 0; g < grids; ++g) {
    const Index row = g < pairs ? 2 * g : pairs + g;
    const DesignPoint& at = design[row];
    even(g, 0) = 1, even(g, 1) = at.spacing * at.spacing - 1;
    even.row(g).tail(n) = at.u.cwiseAbs2().transpose();
    if (g < pairs) {
      odd.row(g) = at.u.transpose();
      odd_y.row(g) = (outputs.row(row) - outputs.row(row + 1)) / 2;
      even_y.row(g) = (outputs.row(row) + outputs.row(row + 1)) / 2;
    } else {
      even_y.row(g) = outputs.row(row);
    }
    const double weight = 1 / (at.spacing * at.spacing);
    even.row(g) *= weight, even_y.row(g) *= weight;
  }
  const MatrixXd slopes = least_squares(odd, odd_y), levels = least_squares(even, even_y);
  linear_ = slopes.transpose();
  square_ = levels.bottomRows(n).transpose();
  level_ = (levels.row(0) + to_no_spacing * levels.row(1)).transpose();

  // At the centre of the design, because the search ends near it. Further out the error is not smaller.
  const MatrixXd odd_rest = odd_y - odd * slopes, even_rest = even_y - even * levels;
  const auto odd_freedom = static_cast<double>(pairs - n), even_freedom = static_cast<double>(grids - n - 2);
  VectorXd here = VectorXd::Zero(n + 2);
  here[0] = 1, here[1] = to_no_spacing;
  const double leverage = here.dot(inverse_normal(even) * here);
  errors_.resize(outputs.cols(), grids + pairs + 1);
  errors_ << even_rest.transpose() * std::sqrt((1 + leverage) / even_freedom),
      odd_rest.transpose() / std::sqrt(odd_freedom), order_unknown * levels.row(1).transpose();
  slope_covariance_ = inverse_normal(odd);
  slope_scatter_ = odd_rest.colwise().squaredNorm().transpose() / odd_freedom;
  freedom_ = even_freedom;
}

VectorXd ResponseSurface::value(const VectorXd& u) const {
  return level_ + linear_ * u + square_ * u.cwiseAbs2();
}

MatrixXd ResponseSurface::slopes(const VectorXd& u) const { return linear_ + 2 * square_ * u.asDiagonal(); }

}  // namespace vacuform
