#include "worker/numerics/box_minimum.hpp"

#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>

#include <algorithm>

namespace vacuform {

Eigen::VectorXd box_minimum(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Eigen::VectorXd& low,
                            const Eigen::VectorXd& high) {
  const auto n = static_cast<int>(b.size());
  CGAL::Quadratic_program<double> program(CGAL::SMALLER, false, 0, false, 0);  // no bounds unless set
  for (int i = 0; i < n; ++i) {
    program.set_c(i, -b[i]);
    program.set_l(i, true, low[i]);
    program.set_u(i, true, high[i]);
    for (int j = 0; j <= i; ++j) program.set_d(i, j, A(i, j));  // CGAL takes twice the matrix of x'Dx
  }
  const auto solution = CGAL::solve_quadratic_program(program, CGAL::Gmpzf());
  Eigen::VectorXd x(n);
  std::transform(solution.variable_values_begin(), solution.variable_values_end(), x.begin(),
                 [](const auto& value) { return CGAL::to_double(value); });
  return x;
}

}  // namespace vacuform
