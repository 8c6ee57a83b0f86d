#include "worker/electrical/body_noise.hpp"

#include <algorithm>
#include <cmath>

#include "worker/electrical/tuning.hpp"

namespace vacuform {

namespace {

constexpr double mu0 = 4e-7 * M_PI;

// P_l and its derivative at x, for l = 1, 2...
class Legendre {
 public:
  explicit Legendre(double x) : x_(x), value_(x) {}
  double value() const { return value_; }
  double slope() const { return slope_; }
  void next() {
    ++l_;
    const double value = ((2 * l_ - 1) * x_ * value_ - (l_ - 1) * before_) / l_;
    slope_ = x_ * slope_ + l_ * value_;
    before_ = value_, value_ = value;
  }

 private:
  const double x_;
  int l_ = 1;
  double before_ = 1, value_, slope_ = 1;
};

}  // namespace

double noise_resistance(const ConductingSphere& body, const LoopOnSphere& a, const LoopOnSphere& b,
                        double angle, double frequency_mhz) {
  const double radius = body.radius_mm / 1000,
               near = body.radius_mm * body.radius_mm / (a.distance_mm * b.distance_mm);
  const double sine_a = std::sin(a.half_angle), sine_b = std::sin(b.half_angle);
  Legendre of_a(std::cos(a.half_angle)), of_b(std::cos(b.half_angle)), between(std::cos(angle));
  double sum = 0, power = near, largest = 0;
  constexpr int most_terms = 100'000;
  for (int l = 1; l < most_terms; ++l, power *= near) {
    // sin a P_l^1(cos a) = sin^2 a P_l'(cos a)
    const double bound = power / (l * (l + 1.0) * (2 * l + 1) * (2 * l + 3)) * of_a.slope() * of_b.slope();
    sum += bound * between.value();
    largest = std::max(largest, std::abs(bound));
    // The slopes grow no faster than l^1.5, which the denominators outweigh.
    if (power < 1e-11 * largest) break;
    of_a.next(), of_b.next(), between.next();
  }
  const double w = angular_frequency(frequency_mhz),
               q = mu0 * sine_a * sine_a / 2 * mu0 * sine_b * sine_b / 2;
  return body.conductivity * w * w * q * 4 * M_PI * radius * radius * radius * sum;
}

double half_space_resistance(double radius_mm, double above_mm, double conductivity, double frequency_mhz) {
  const double x = above_mm / radius_mm;
  const auto integrand = [x](double t) {
    const double f = t > 0 ? std::cyl_bessel_j(1.0, t) / t : 0.5;
    return f * f * std::exp(-2 * t * x);
  };
  // Simpson's rule; J1^2 is 1 / (pi t) on average where it goes on.
  constexpr double end = 200, step = 0.05;
  constexpr int pieces = 4000;
  double integral = 0;
  for (int i = 0; i <= pieces; ++i)
    integral += (i == 0 || i == pieces ? 1 : i % 2 == 1 ? 4 : 2) * integrand(i * step);
  integral *= step / 3;
  if (x * end < 1) integral += std::exp(-2 * end * x) / (2 * M_PI * end * end);
  const double w = angular_frequency(frequency_mhz), a = radius_mm / 1000;
  return M_PI / 4 * conductivity * w * w * mu0 * mu0 * a * a * a * integral;
}

}  // namespace vacuform
