#include <cmath>
#include <stdexcept>

#include "worker/flattening/held_points.hpp"
#include "worker/flattening/methods.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/numerics/supernodal_cholesky.hpp"

namespace vacuform {

namespace {

// The quadratic form of w A (s1 - s2)^2 = w A (|J|^2 - 2 det J) in a triangle's corners.
ChartMatrix<2>::Local conformal(const ChartElement& element, double weight) {
  ChartMatrix<2>::Local Q = ChartMatrix<2>::Local::Zero();
  const Eigen::Matrix3d dirichlet = weight * element.area * element.gradient * element.gradient.transpose();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int d = 0; d < 2; ++d) Q(2 * i + d, 2 * j + d) = dirichlet(i, j);
  // 2 A det J is twice the triangle's area in the chart, the sum of its edges' cross products.
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    Q(2 * i, 2 * j + 1) -= weight / 2, Q(2 * j + 1, 2 * i) -= weight / 2;
    Q(2 * i + 1, 2 * j) += weight / 2, Q(2 * j, 2 * i + 1) += weight / 2;
  }
  return Q;
}

// Both coordinates of all vertices as one column.
Eigen::VectorXd column_of(const std::vector<Eigen::Vector2d>& uv) {
  return Eigen::Map<const Eigen::VectorXd>(uv.front().data(), static_cast<Eigen::Index>(2 * uv.size()));
}
void set_column(std::vector<Eigen::Vector2d>& uv, const Eigen::VectorXd& column) {
  for (std::size_t i = 0; i < uv.size(); ++i) uv[i] = column.segment<2>(static_cast<Eigen::Index>(2 * i));
}

struct Masses {
  Eigen::VectorXd of;  // a third of the area around, for each coordinate of each vertex
  double total = 0;
};
Masses masses(const Chart& chart, const std::vector<ChartElement>& all) {
  Masses m{Eigen::VectorXd::Zero(static_cast<Eigen::Index>(2 * chart.uv.size()))};
  for (std::size_t k = 0; k < all.size(); ++k) {
    for (const int v : chart.triangles[k]) m.of.segment<2>(2 * v).array() += all[k].area / 3;
    m.total += all[k].area;
  }
  return m;
}

// Its centre of mass to the origin.
void centre(Eigen::VectorXd& x, const Masses& mass) {
  Eigen::Vector2d mean(0, 0);
  for (Eigen::Index i = 0; i < x.rows(); i += 2) mean += mass.of[i] * x.segment<2>(i);
  mean /= mass.total;
  for (Eigen::Index i = 0; i < x.rows(); i += 2) x.segment<2>(i) -= mean;
}

double area_in_plane(const Chart& chart) {
  double twice = 0;
  for (const Triangle& t : chart.triangles) {
    const Eigen::Vector2d a = chart.uv[t[1]] - chart.uv[t[0]], b = chart.uv[t[2]] - chart.uv[t[0]];
    twice += cross(a, b);
  }
  return twice / 2;
}

}  // namespace

Result<FlatteningOutcome> flatten_lscm(Chart& chart, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::flattening, 0));
  const auto all = elements(chart);
  const Masses mass = masses(chart, all);
  ChartMatrix<2> Q(chart);
  // Lifts the free shifts off zero, far below the least conformal distortion of any chart.
  const double lift = chart.pins.empty() ? 1e-5 / mass.total : 0;
  Q.reset(0);
  for (std::size_t k = 0; k < all.size(); ++k) {
    auto local = conformal(all[k], chart.weight_of(k));
    local.diagonal().array() += lift * all[k].area / 3;
    Q.add(k, local);
  }
  const double stiffness = stiffness_of_pins(chart);
  add_pins(Q, chart.pins, stiffness);
  SupernodalCholesky cholesky(Q.matrix(), 2);
  VACUFORM_CHECK(context.step(Stage::flattening, 0.2));
  if (!cholesky.factor(Q.matrix())) throw std::logic_error("the conformal energy is not positive definite");

  FlatteningOutcome outcome;
  Eigen::VectorXd x = column_of(chart.uv);
  if (!chart.pins.empty()) {
    x.setZero();
    for (const ChartPin& pin : chart.pins)
      for (int i = 0; i < 3; ++i)
        x.segment<2>(2 * chart.triangles[pin.triangle][i]) += stiffness * pin.corners[i] * pin.target;
    cholesky.solve(x);
    set_column(chart.uv, x);
    return FlatteningOutcome{1, true};
  }
  // Inverse iteration for the least eigenvector besides the shifts.
  constexpr int most_iterations = 100;
  constexpr double least_turn = 1e-9;
  centre(x, mass);
  x /= std::sqrt(x.dot(mass.of.cwiseProduct(x)));
  while (outcome.iterations < most_iterations && !outcome.converged) {
    VACUFORM_CHECK(context.step(Stage::flattening, 1 - 1 / (1.5 + 0.1 * outcome.iterations)));
    const Eigen::VectorXd before = x;
    x = mass.of.cwiseProduct(x);
    cholesky.solve(x);
    centre(x, mass);
    x /= std::sqrt(x.dot(mass.of.cwiseProduct(x)));
    ++outcome.iterations;
    const Eigen::VectorXd turned = x - before;
    outcome.converged = turned.dot(mass.of.cwiseProduct(turned)) < least_turn;
  }
  set_column(chart.uv, x);
  const double area = area_in_plane(chart);
  if (!(area > 0))
    return fail(Code::unusable_surface, "the region has no conformal map", "flattening.method",
                "use flattening.method = arap");
  for (auto& p : chart.uv) p *= std::sqrt(mass.total / area);
  return outcome;
}

}  // namespace vacuform
