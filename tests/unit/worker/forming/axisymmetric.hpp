// The exact forming of axisymmetric membranes, by shooting: what the sheet of triangles is held to.
//
// A membrane with the energy W(l1, l2) per rest area and unit thickness, rest radius a, deformed to (r, z) with the
// slope t (dr = l1 cos t da, dz = l1 sin t da), is at rest under the pressure p from above when
//   d(a W1)/da = W2 cos t,   W1 dt/da = p l2 l1 - (W2 / a) sin t     (W1 = dW/dl1, W2 = dW/dl2, l2 = r / a)
// (Adkins and Rivlin, "Large elastic deformations of isotropic materials IX", Phil. Trans. R. Soc. A 244, 1952).
// It sticks where it touches, and leaves the mold along the mold's tangent: so the front of contact moves by
// d(arc) = l1 da with the l1 of the free film at the front, and the whole process is one ordinary differential equation.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "worker/forming/membrane.hpp"

namespace vacuform::exact {

struct Film {  // one place of it
  double r, z, slope, l1;
};

struct Law {
  MembraneLaw law;
  // With l1 < l2 the density is asked for the other way round: it is symmetric.
  Density operator()(double l1, double l2) const {
    if (l1 >= l2) return density(law, l1, l2);
    Density d = density(law, l2, l1);
    std::swap(d.W1, d.W2), std::swap(d.W11, d.W22);
    return d;
  }
};

// From rest radius a to b, in `steps` of the classical Runge-Kutta method that grow with the radius.
inline Film march(const Law& law, double p, Film f, double a, double b, int steps) {
  const auto slope = [&](double at, const Film& y) {
    const double l2 = y.r / at, c = std::cos(y.slope), s = std::sin(y.slope);
    const Density d = law(y.l1, l2);
    const double l2_rate = (y.l1 * c - l2) / at;
    return Film{y.l1 * c, y.l1 * s, (p * l2 * y.l1 - d.W2 / at * s) / d.W1,
                ((d.W2 * c - d.W1) / at - d.W12 * l2_rate) / d.W11};
  };
  const auto plus = [](const Film& y, double h, const Film& k) {
    return Film{y.r + h * k.r, y.z + h * k.z, y.slope + h * k.slope, y.l1 + h * k.l1};
  };
  const double growth = std::pow(b / a, 1.0 / steps);
  double at = a;
  for (int i = 0; i < steps; ++i, at *= growth) {
    const double h = at * (growth - 1);
    const Film k1 = slope(at, f), k2 = slope(at + h / 2, plus(f, h / 2, k1)),
               k3 = slope(at + h / 2, plus(f, h / 2, k2)), k4 = slope(at + h, plus(f, h, k3));
    f = plus(plus(plus(plus(f, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  return f;
}

// Newton's method by differences; the unknowns on entry are the guess. False where it fails.
template <int n>
bool solve(const std::function<Eigen::Matrix<double, n, 1>(const Eigen::Matrix<double, n, 1>&)>& residual,
           Eigen::Matrix<double, n, 1>& x) {
  for (int i = 0; i < 60; ++i) {
    const Eigen::Matrix<double, n, 1> f = residual(x);
    if (!f.allFinite()) return false;
    if (f.cwiseAbs().maxCoeff() < 1e-11) return true;
    Eigen::Matrix<double, n, n> J;
    for (int k = 0; k < n; ++k) {
      Eigen::Matrix<double, n, 1> y = x;
      const double e = 1e-7 * std::max(1e-3, std::abs(x[k]));
      y[k] += e;
      J.col(k) = (residual(y) - f) / e;
    }
    Eigen::Matrix<double, n, 1> step = J.fullPivLu().solve(f);
    const double size = (step.array() / x.array().abs().max(0.1)).abs().maxCoeff();
    if (size > 0.2) step *= 0.2 / size;
    x -= step;
  }
  return residual(x).cwiseAbs().maxCoeff() < 1e-6;
}

// What has landed, in the order of landing.
struct Landed {
  double rest;       // radius on the flat sheet, over that of the rim or the mold
  double place;      // slant distance from the rim over the wall's length; or the polar angle, radians
  double thickness;  // over the flat sheet's
};

// A pit of rim radius 1 whose wall makes `angle` with the flat sheet; down to where the free cap has the rest radius
// `last`.
inline std::vector<Landed> female_cone(MembraneLaw law_, double angle, double last = 0.02) {
  const Law law{law_};
  using V = Eigen::Vector2d;  // stretch at the pole, pressure times the rest radius of the cap
  V x(angle / std::sin(angle), 2 * std::sin(angle));
  const auto front = [&](double a, double r, V& unknown) {  // meridional stretch of the cap at its rim
    Film end{};
    const bool found = solve<2>(
        [&](const V& v) {
          const double p = v[1] / a, a0 = 1e-4 * a;
          const Density d = law(v[0], v[0] * (1 - 1e-12));
          const double slope = p / (2 * d.W1 / v[0]) * v[0] * a0;
          end = march(law, p, {v[0] * a0, 0, slope, v[0]}, a0, a, 100);
          return V(end.r / r - 1, end.slope - angle);
        },
        unknown);
    return found ? end.l1 : NAN;
  };
  std::vector<Landed> out;
  constexpr double shrink = 0.98;
  double a = 1, s = 0;  // slant distance over that of the wall
  while (a > last) {
    const double l1 = front(a, 1 - s, x), half = std::sqrt(shrink);
    if (!std::isfinite(l1)) return {};
    out.push_back({a, s, a / (l1 * (1 - s))});
    const double s_half = s + l1 * a * (1 - half) * std::cos(angle);
    s += front(a * half, 1 - s_half, x) * a * (1 - shrink) * std::cos(angle);
    a *= shrink;
  }
  return out;
}

// A hemisphere of radius 1 under a clamp ring lowered to its base plane, the platform; then vacuum. Until the free film
// between mold and platform has come down to the polar angle `last`.
inline std::vector<Landed> male_hemisphere(MembraneLaw law_, double ring, double last) {
  const Law law{law_};
  std::vector<Landed> out;
  constexpr int steps = 80;
  const double d_polar = 0.25 * std::numbers::pi / 180;
  double polar = 8 * d_polar, a = std::sin(polar);
  double l1 = 1 / std::cos(polar), p = 0;             // at the front on the mold; the pressure
  double outer = ring, r_outer = ring, l1_outer = 1;  // the front on the platform
  bool on_platform = false;
  out.push_back({a, polar, std::cos(polar)});
  // The film from the front on the mold outwards, at its outer end.
  const auto film = [&](double at, double angle, double stretch, double pressure, double to) {
    return march(law, pressure, {std::sin(angle), std::cos(angle), -angle, stretch}, at, to, steps);
  };
  // The free film with the front at `at`, `angle`: gives its l1 at the front and moves p and the outer front.
  const auto settle = [&](double at, double angle, double& frame) {
    Film end{};
    if (p == 0) {
      Eigen::Matrix<double, 1, 1> x(l1);
      const bool found = solve<1>(
          [&](const Eigen::Matrix<double, 1, 1>& v) {
            end = film(at, angle, v[0], 0, ring);
            return Eigen::Matrix<double, 1, 1>(end.r - ring);
          },
          x);
      l1 = found ? x[0] : NAN;
      frame = end.z;
      return;
    }
    if (!on_platform) {
      Eigen::Vector2d x(l1, p);
      const bool found = solve<2>(
          [&](const Eigen::Vector2d& v) {
            end = film(at, angle, v[0], v[1], ring);
            return Eigen::Vector2d(end.r - ring, end.z);
          },
          x);
      l1 = found ? x[0] : NAN;
      p = x[1];
      l1_outer = end.l1;
      on_platform = end.slope >= 0;
      return;
    }
    Eigen::Vector3d x(l1, p, outer);
    const bool found = solve<3>(
        [&](const Eigen::Vector3d& v) {
          end = film(at, angle, v[0], v[1], v[2]);
          return Eigen::Vector3d(end.r - (r_outer - (l1_outer + end.l1) / 2 * (outer - v[2])), end.z,
                                 end.slope);
        },
        x);
    l1 = found ? x[0] : NAN;
    p = x[1];
    r_outer -= (l1_outer + end.l1) / 2 * (outer - x[2]);
    outer = x[2];
    l1_outer = end.l1;
  };
  double frame = 1;
  settle(a, polar, frame);
  while (polar < last) {
    const double before = l1;
    a += d_polar / l1;  // a predictor, then the mean of both ends
    settle(a, polar + d_polar, frame);
    a += d_polar * (2 / (before + l1) - 1 / before);
    polar += d_polar;
    settle(a, polar, frame);
    if (!std::isfinite(l1)) return {};
    out.push_back({a, polar, a / (l1 * std::sin(polar))});
    if (p == 0 && frame <= 0) p = 1e-3;
  }
  return out;
}

inline Landed at(const std::vector<Landed>& landed, double place) {
  for (std::size_t i = 1; i < landed.size(); ++i)
    if (landed[i].place >= place) {
      const Landed &x = landed[i - 1], &y = landed[i];
      const double w = (place - x.place) / (y.place - x.place);
      return {(1 - w) * x.rest + w * y.rest, place, (1 - w) * x.thickness + w * y.thickness};
    }
  return {NAN, NAN, NAN};
}

}  // namespace vacuform::exact
