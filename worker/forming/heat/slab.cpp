#include "worker/forming/heat/slab.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/forming/heat/irradiance.hpp"

namespace vacuform {

namespace {

constexpr int most_newton_steps = 50;
constexpr double newton_within =
    1e-2;  // of a step, kelvin; the next would be the square of this, which is round-off
constexpr std::size_t most_layers = 64;

}  // namespace

Slab::Slab(const SlabMaterial& m, double thickness_mm, int layers)
    : capacity_(m.density_kg_m3 * m.heat_capacity_j_kgk * thickness_mm / 1000 / layers),
      conductance_(m.conductivity_w_mk / (thickness_mm / 1000 / layers)),
      absorptance_(m.absorptance) {
  const double layer_mm = thickness_mm / layers;
  const auto passes = [&](int i) { return i == 0 ? 1.0 : std::exp(-m.absorption_1_mm * layer_mm * i); };
  for (int i = 0; i < layers; ++i) from_top_.push_back(passes(i) - passes(i + 1));
  from_bottom_.assign(from_top_.rbegin(), from_top_.rend());
}

double Slab::solve_stage(std::span<double> u, std::span<const double> start, double step, const Exposure& top,
                         const Exposure& bottom) const {
  const std::size_t n = from_top_.size();
  // The air exchanges heat with the outer layers through half of their thickness.
  const auto to_air = [&](double h) { return h > 0 ? 1 / (1 / h + 0.5 / conductance_) : 0.0; };
  const double air_top = to_air(top.convection_w_m2k), air_bottom = to_air(bottom.convection_w_m2k);
  const double ratio = step / capacity_;
  std::array<double, most_layers> upper{}, right{};  // Thomas' algorithm
  double change = 2 * newton_within;
  for (int newton = 0; newton < most_newton_steps && change > newton_within; ++newton) {
    for (std::size_t i = 0; i < n; ++i) {
      const double kelvin = u[i] - absolute_zero, cube = stefan_boltzmann * kelvin * kelvin * kelvin;
      const double loses = absorptance_ * (from_top_[i] + from_bottom_[i]);
      const double gains =
          absorptance_ * (from_top_[i] * top.irradiance_w_m2 + from_bottom_[i] * bottom.irradiance_w_m2);
      // Linearised about u: the loss sigma T^4 becomes 4 sigma T^3 u_new - (4 sigma T^3 u - sigma T^4).
      double diagonal = 4 * loses * cube, known = gains + loses * cube * (4 * u[i] - kelvin);
      if (i > 0) diagonal += conductance_;
      if (i + 1 < n) diagonal += conductance_;
      if (i == 0) diagonal += air_top, known += air_top * top.air_celsius;
      if (i + 1 == n) diagonal += air_bottom, known += air_bottom * bottom.air_celsius;
      const double off = -ratio * conductance_;
      double pivot = 1 + ratio * diagonal, value = start[i] + ratio * known;
      if (i > 0) pivot -= off * upper[i - 1], value -= off * right[i - 1];
      const double inverse = 1 / pivot;
      upper[i] = off * inverse;
      right[i] = value * inverse;
    }
    change = 0;
    double next = 0;
    for (std::size_t i = n; i-- > 0;) {
      next = i + 1 == n ? right[i] : right[i] - upper[i] * next;
      change = std::max(change, std::abs(next - u[i]));
      u[i] = next;
    }
  }
  double power = air_top * (top.air_celsius - u[0]) + air_bottom * (bottom.air_celsius - u[n - 1]);
  for (std::size_t i = 0; i < n; ++i) {
    const double square = (u[i] - absolute_zero) * (u[i] - absolute_zero);
    const double emission = stefan_boltzmann * square * square;
    power += absorptance_ * (from_top_[i] * (top.irradiance_w_m2 - emission) +
                             from_bottom_[i] * (bottom.irradiance_w_m2 - emission));
  }
  return power;
}

double Slab::advance(std::span<double> celsius, double seconds, const Exposure& top,
                     const Exposure& bottom) const {
  const double gamma = 1 - std::sqrt(0.5);
  const std::size_t n = from_top_.size();
  std::array<double, most_layers> stage{}, start{};
  for (std::size_t i = 0; i < n; ++i) stage[i] = celsius[i];
  const double first = solve_stage({stage.data(), n}, celsius, gamma * seconds, top, bottom);
  // The rate of the first stage is (stage - celsius) / (gamma * seconds).
  for (std::size_t i = 0; i < n; ++i) start[i] = celsius[i] + (1 - gamma) / gamma * (stage[i] - celsius[i]);
  for (std::size_t i = 0; i < n; ++i) celsius[i] = stage[i];
  const double second = solve_stage(celsius, {start.data(), n}, gamma * seconds, top, bottom);
  return seconds * ((1 - gamma) * first + gamma * second);
}

double Slab::energy(std::span<const double> celsius) const {
  double sum = 0;
  for (const double c : celsius) sum += c;
  return capacity_ * sum;
}

double Slab::top_celsius(std::span<const double> c) { return 1.5 * c[0] - 0.5 * c[1]; }
double Slab::bottom_celsius(std::span<const double> c) {
  return 1.5 * c[c.size() - 1] - 0.5 * c[c.size() - 2];
}

}  // namespace vacuform
