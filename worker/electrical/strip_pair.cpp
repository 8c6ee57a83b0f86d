#include "worker/electrical/strip_pair.hpp"

#include <cmath>

namespace vacuform {

double strip_pair_nh_per_mm(double width_mm, double between_mm) {
  constexpr double mu0_nh_mm = 0.4 * M_PI;
  const double k = between_mm / (between_mm + 2 * width_mm);
  return mu0_nh_mm * std::comp_ellint_1(k) / std::comp_ellint_1(std::sqrt(1 - k * k));
}

}  // namespace vacuform
