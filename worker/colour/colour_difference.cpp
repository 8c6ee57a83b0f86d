#include "worker/colour/colour_difference.hpp"

#include <cmath>
#include <numbers>

namespace vacuform {

using Eigen::Vector3d;

Vector3d lab_of(const Eigen::Vector3f& linear) {
  Eigen::Matrix3d to_xyz;
  to_xyz << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920, 0.9503041;
  const Vector3d xyz = (to_xyz * linear.cast<double>()).cwiseQuotient(Vector3d(0.95047, 1, 1.08883));
  const Vector3d f = xyz.unaryExpr(
      [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; });
  return {116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z())};
}

double ciede2000(const Vector3d& one, const Vector3d& other) {
  constexpr double pi = std::numbers::pi, rad = pi / 180, to_the_7th = 6103515625.0;  // 25^7
  const auto chroma = [](const Vector3d& c) { return std::hypot(c.y(), c.z()); };
  const double mean_7 = std::pow((chroma(one) + chroma(other)) / 2, 7);
  const double g = 0.5 * (1 - std::sqrt(mean_7 / (mean_7 + to_the_7th)));
  const double a1 = (1 + g) * one.y(), a2 = (1 + g) * other.y();
  const double c1 = std::hypot(a1, one.z()), c2 = std::hypot(a2, other.z());
  const auto hue = [&](double a, double b) {
    const double h = a == 0 && b == 0 ? 0 : std::atan2(b, a);
    return h < 0 ? h + 2 * pi : h;
  };
  const double h1 = hue(a1, one.z()), h2 = hue(a2, other.z());
  double turn = c1 * c2 == 0 ? 0 : h2 - h1;
  if (turn > pi) turn -= 2 * pi;
  if (turn < -pi) turn += 2 * pi;
  const double lightness = other.x() - one.x(), chroma_change = c2 - c1,
               hue_change = 2 * std::sqrt(c1 * c2) * std::sin(turn / 2);
  const double l = (one.x() + other.x()) / 2, c = (c1 + c2) / 2;
  double h = c1 * c2 == 0 ? h1 + h2 : (h1 + h2) / 2;
  if (c1 * c2 != 0 && std::abs(h1 - h2) > pi) h += h1 + h2 < 2 * pi ? pi : -pi;
  const double t = 1 - 0.17 * std::cos(h - 30 * rad) + 0.24 * std::cos(2 * h) +
                   0.32 * std::cos(3 * h + 6 * rad) - 0.2 * std::cos(4 * h - 63 * rad);
  const double c7 = std::pow(c, 7);
  const double sl = 1 + 0.015 * (l - 50) * (l - 50) / std::sqrt(20 + (l - 50) * (l - 50)), sc = 1 + 0.045 * c,
               sh = 1 + 0.015 * c * t;
  const double bump = (h / rad - 275) / 25;
  const double rt = -2 * std::sqrt(c7 / (c7 + to_the_7th)) * std::sin(60 * rad * std::exp(-bump * bump));
  const double dl = lightness / sl, dc = chroma_change / sc, dh = hue_change / sh;
  return std::sqrt(dl * dl + dc * dc + dh * dh + rt * dc * dh);
}

}  // namespace vacuform
