// Neumann's integral, softened by the distance between the conductors: the inner of its two integrals in closed form
// where segments are near each other, Gauss's points where they are far.
#include "worker/coils/inductance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace vacuform {

namespace {

using Eigen::Vector3d;

struct Node {
  double at, weight;  // on [0, 1]
};
constexpr std::array<Node, 2> two{{{0.21132486540518712, 0.5}, {0.78867513459481288, 0.5}}};
constexpr std::array<Node, 4> four{{{0.069431844202973712, 0.17392742256872693},
                                    {0.33000947820757187, 0.32607257743127307},
                                    {0.66999052179242813, 0.32607257743127307},
                                    {0.93056815579702629, 0.17392742256872693}}};

struct StraightWire {
  Vector3d start, way;
  double length;
};

StraightWire straight_wire(Loop loop, std::size_t i) {
  const Vector3d way = loop[(i + 1) % loop.size()] - loop[i];
  return {loop[i], way, way.norm()};
}

// The exponential of asinh x, without cancellation.
double exp_asinh(double x) {
  const double root = std::sqrt(x * x + 1);
  return x > 0 ? root + x : 1 / (root - x);
}

// The integral of 1 / sqrt(r^2 + gap^2) along b, r the distance from p.
double along(const Vector3d& p, const StraightWire& b, double gap) {
  const Vector3d unit = b.way / b.length;
  const double foot = (p - b.start).dot(unit);
  const double aside = std::sqrt(((p - b.start) - foot * unit).squaredNorm() + gap * gap);
  return std::log(exp_asinh((b.length - foot) / aside) * exp_asinh(foot / aside));
}

double on_part(const StraightWire& a, double from, double to, const StraightWire& b, double gap) {
  double sum = 0;
  for (const Node& n : four) sum += n.weight * along(a.start + (from + n.at * (to - from)) * a.way, b, gap);
  return sum * (to - from) * a.length;
}

// Where a comes nearest to b's line, as a fraction of a.
double nearest(const StraightWire& a, const StraightWire& b) {
  const Vector3d unit = b.way / b.length, between = a.start - b.start;
  const Vector3d d = a.way - a.way.dot(unit) * unit, e = between - between.dot(unit) * unit;
  return d.squaredNorm() > 0 ? std::clamp(-e.dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.5;
}

// The double integral of dl.dl / sqrt(r^2 + gap^2) over two straight segments.
double neumann(const StraightWire& a, const StraightWire& b, double gap) {
  if (a.length == 0 || b.length == 0) return 0;
  const double cosine = a.way.dot(b.way) / (a.length * b.length);
  const double apart = (a.start + 0.5 * a.way - b.start - 0.5 * b.way).norm(), size = a.length + b.length;
  if (apart > 8 * size) return cosine * a.length * b.length / std::sqrt(apart * apart + gap * gap);
  if (apart > 2 * size) {
    double sum = 0;
    for (const Node& n : two)
      for (const Node& m : two)
        sum += 0.25 / std::sqrt((a.start + n.at * a.way - b.start - m.at * b.way).squaredNorm() + gap * gap);
    return cosine * sum * a.length * b.length;
  }
  if (apart > 0.6 * size || gap > 0.3 * size) return cosine * on_part(a, 0, 1, b, gap);
  // Crossing or touching: parts that grow away from the nearest place, where the integrand is logarithmic.
  constexpr std::array<double, 5> growing{0, 0.01, 0.1, 0.4, 1};
  const double middle = nearest(a, b);
  double sum = 0;
  for (std::size_t k = 0; k + 1 < growing.size(); ++k) {
    sum += on_part(a, middle * (1 - growing[k + 1]), middle * (1 - growing[k]), b, gap);
    sum += on_part(a, middle + (1 - middle) * growing[k], middle + (1 - middle) * growing[k + 1], b, gap);
  }
  return cosine * sum;
}

}  // namespace

double mutual_inductance_nh(Loop a, Loop b, double gap_mm) {
  std::vector<StraightWire> of_b;
  of_b.reserve(b.size());
  for (std::size_t j = 0; j < b.size(); ++j) of_b.push_back(straight_wire(b, j));
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const StraightWire s = straight_wire(a, i);
    for (const StraightWire& t : of_b) sum += neumann(s, t, gap_mm);
  }
  return mu0_over_4pi * sum;
}

double self_inductance_nh(Loop loop, double width_mm) {
  return mutual_inductance_nh(loop, loop, width_mm / 4);
}

double coupling(Loop a, double width_a_mm, Loop b, double width_b_mm) {
  return mutual_inductance_nh(a, b) /
         std::sqrt(self_inductance_nh(a, width_a_mm) * self_inductance_nh(b, width_b_mm));
}

}  // namespace vacuform
