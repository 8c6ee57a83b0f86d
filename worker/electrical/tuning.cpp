#include "worker/electrical/tuning.hpp"

#include <array>
#include <cmath>

namespace vacuform {

double angular_frequency(double mhz) { return 2e6 * M_PI * mhz; }

double tuning_pf(double inductance_nh, double frequency_mhz) {
  const double w = angular_frequency(frequency_mhz);
  return 1e12 / (w * w * inductance_nh * 1e-9);
}

double quality(double inductance_nh, double frequency_mhz, double resistance_ohm) {
  return angular_frequency(frequency_mhz) * inductance_nh * 1e-9 / resistance_ohm;
}

double noise_figure_db(double coil_ohm, double body_ohm) { return 10 * std::log10(1 + coil_ohm / body_ohm); }

Match match(double inductance_nh, double loop_ohm, double port_ohm, double frequency_mhz) {
  if (loop_ohm >= port_ohm) return {0, tuning_pf(inductance_nh, frequency_mhz)};
  const double w = angular_frequency(frequency_mhz), rest = std::sqrt(loop_ohm * (port_ohm - loop_ohm));
  return {1e12 * std::sqrt((port_ohm - loop_ohm) / loop_ohm) / port_ohm / w,
          1e12 / (w * (w * inductance_nh * 1e-9 - rest))};
}

double coupled_current(double k, double inductance_nh, double frequency_mhz, double resistance_ohm,
                       double blocking_ohm) {
  return std::abs(k) * angular_frequency(frequency_mhz) * inductance_nh * 1e-9 /
         (resistance_ohm + blocking_ohm);
}

StandardValue standard_value(double wanted_pf) {
  constexpr std::array<double, 25> e24{1.0, 1.1, 1.2, 1.3, 1.5, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0, 3.3,
                                       3.6, 3.9, 4.3, 4.7, 5.1, 5.6, 6.2, 6.8, 7.5, 8.2, 9.1, 10.0};
  const double decade = std::pow(10, std::floor(std::log10(wanted_pf)));
  double best = e24[0] * decade;
  for (const double value : e24)
    if (std::abs(std::log(value * decade / wanted_pf)) < std::abs(std::log(best / wanted_pf)))
      best = value * decade;
  return {best, std::sqrt(wanted_pf / best) - 1};
}

}  // namespace vacuform
