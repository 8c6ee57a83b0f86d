#include "worker/coils/array_relaxation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "worker/coils/inductance.hpp"
#include "worker/numerics/dense.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The table: ratios from `first` on, tilts from 0 on.
constexpr double first_ratio = 0.3, ratio_step = 0.025, tilt_step = M_PI / 18;
constexpr int ratios = 85, tilts = 14;

// A circle of radius 1 mm about a place of the sphere, whose cap has the circle's area in the plane.
std::vector<Vector3d> circle_on(double sphere, double at) {
  constexpr int points = 40;
  const Vector3d up(std::sin(at), 0, std::cos(at)), along(std::cos(at), 0, -std::sin(at));
  const double half = 2 * std::asin(std::min(1.0, 1 / (2 * sphere)));
  std::vector<Vector3d> out;
  for (int i = 0; i < points; ++i) {
    const double turn = 2 * M_PI * i / points;
    out.push_back(sphere * (std::cos(half) * up +
                            std::sin(half) * (std::cos(turn) * along + std::sin(turn) * Vector3d::UnitY())));
  }
  return out;
}

double mutual_of_units(double ratio, double tilt) {
  constexpr double flat = 1e-3, gap = 0.004;
  const double angle = std::max(tilt, flat), sphere = std::max(0.51, ratio / std::sin(angle / 2));
  return mutual_inductance_nh(circle_on(sphere, 0), circle_on(sphere, angle), gap);
}

// What weighs as much: a coupling, a move, a part outside, a drift. Couplings beyond a bound count by their sixth power, too.
constexpr double coupling_unit = 0.01, coupling_bound = 0.01, move_unit_mm = 100, outside_unit_mm = 0.3;
constexpr double on_head_mm = 0.3;   // this much outside counts as on the head
constexpr double drift_unit_mm = 1;  // of each circle
constexpr double apart_weight = 0.35, overlapping_ratio = 0.88, apart_ratio = 1.08;

Vector3d mean_of(const std::vector<Vector3d>& vectors) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& v : vectors) sum += v;
  return sum / static_cast<double>(vectors.size());
}

double weight_of(double ratio) {
  return 1 + (apart_weight - 1) *
                 std::clamp((ratio - overlapping_ratio) / (apart_ratio - overlapping_ratio), 0.0, 1.0);
}

}  // namespace

CircleCouplings::CircleCouplings() {
  for (int i = 0; i < ratios; ++i)
    for (int j = 0; j < tilts; ++j)
      m_.push_back(mutual_of_units(first_ratio + ratio_step * i, tilt_step * j));
}

CircleCouplings::Coupling CircleCouplings::at(double ratio, double tilt, double radius_mm,
                                              double trace_mm) const {
  const double x = (std::max(ratio, first_ratio) - first_ratio) / ratio_step;
  const double y = std::min(tilt / tilt_step, tilts - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  if (i + 1 >= ratios) return {};
  const auto node = [&](int a, int b) { return m_[index((i + a) * tilts + j + b)]; };
  const double near = node(0, 0) + (y - j) * (node(0, 1) - node(0, 0)),
               far = node(1, 0) + (y - j) * (node(1, 1) - node(1, 0));
  const double self = 4 * M_PI * mu0_over_4pi * (std::log(32 * radius_mm / trace_mm) - 2);  // over the radius
  return {(near + (x - i) * (far - near)) / self, (far - near) / ratio_step / self};
}

bool Arrangement::is_whole() const {
  const auto loops = static_cast<double>(centres.size());
  return outside_mm <= on_head_mm &&
         overlaps >= static_cast<int>(0.75 * (3 * loops - std::sqrt(12 * loops - 3)));
}

double Arrangement::score() const {
  return std::max({overlapping / 0.0125, apart / 0.031, rms / 0.009, drift_mm / 8,
                   outside_mm <= on_head_mm ? 0 : 1 + outside_mm});
}

const Arrangement& best_of(const std::vector<Arrangement>& arrangements) {
  constexpr double good = 1.35, as_well = 1.1;
  double least = std::numeric_limits<double>::infinity();
  for (const Arrangement& one : arrangements)
    if (one.is_whole()) least = std::min(least, one.score());
  const auto rank = [&](const Arrangement& one) {
    const bool counts = one.is_whole() && one.score() <= std::max(good, as_well * least);
    return std::tuple(!counts, counts ? -one.overlaps : 0, !one.is_whole(), one.score());
  };
  return *std::min_element(arrangements.begin(), arrangements.end(),
                           [&](const Arrangement& a, const Arrangement& b) { return rank(a) < rank(b); });
}

struct Relaxation::State {
  std::vector<Centre> centres;
  double radius_mm = 0, trace_mm = 0;
  std::vector<Vector3d> places, normals;
  struct Pair {
    int a, b;
    double ratio, k, per_ratio, weight;
  };
  std::vector<Pair> pairs;
  std::vector<double> outside;   // mm that a circle reaches beyond the border; negative: inside
  std::vector<Vector3d> inward;  // from the nearest place of the border
  Middle about;

  Vector3d along(const Vector3d& direction) const { return direction - about.up.dot(direction) * about.up; }
  Vector3d drift() const { return along(mean_of(places) - about.place); }  // from the middle, along the head
};

Relaxation::Relaxation(const ChartedSurface& charted, const Half& half)
    : charted_(&charted), half_(half), border_(charted.border()) {
  constexpr std::size_t most_samples = 4000;
  const InkedSurface& surface = charted.surface();
  const std::vector<int>& chart = charted.flattening().triangles;
  const std::size_t stride = std::max<std::size_t>(1, chart.size() / most_samples);
  for (std::size_t i = 0; i < chart.size(); i += stride) {
    const Triangle& c = surface.triangles()[index(chart[i])];
    const auto at = [&](std::size_t k) -> const Vector3d& { return surface.inked()[index(c[k])]; };
    samples_.push_back({(at(0) + at(1) + at(2)) / 3, (at(1) - at(0)).cross(at(2) - at(0)) / 2});
  }
  std::stable_sort(samples_.begin(), samples_.end(),
                   [](const Sample& a, const Sample& b) { return a.place.x() < b.place.x(); });
}

Relaxation::State Relaxation::state(std::vector<Centre> centres, double radius_mm, double trace_mm) const {
  State out;
  out.centres = std::move(centres), out.radius_mm = radius_mm, out.trace_mm = trace_mm;
  const InkedSurface& surface = charted_->surface();
  for (const Centre& c : out.centres) {
    const Vector3d place = surface.place(c.point);
    Vector3d normal = Vector3d::Zero();
    const auto from = std::lower_bound(samples_.begin(), samples_.end(), place.x() - radius_mm,
                                       [](const Sample& s, double x) { return s.place.x() < x; });
    for (auto s = from; s != samples_.end() && s->place.x() < place.x() + radius_mm; ++s)
      if ((s->place - place).squaredNorm() < radius_mm * radius_mm) normal += s->normal;
    if (normal.dot(surface.normal(c.point.triangle)) <= 0) normal = surface.normal(c.point.triangle);
    out.places.push_back(place);
    out.normals.push_back(normal.normalized());
    double least = std::numeric_limits<double>::infinity();
    Vector3d nearest = Vector3d::Zero();
    for (const Vector3d& b : border_)
      if (const double square = (place - b).squaredNorm(); square < least)
        least = square, nearest = place - b;
    const bool on = charted_->on_chart(c.point.triangle);
    const double mm = std::sqrt(least);
    out.outside.push_back(radius_mm + trace_mm / 2 + 1 - (on ? mm : -mm));
    out.inward.push_back((on ? 1 : -1) * nearest / std::max(1e-6, mm));
  }
  const int count = static_cast<int>(out.centres.size());
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      const double ratio = (out.places[index(a)] - out.places[index(b)]).norm() / (2 * radius_mm);
      const double tilt = std::acos(std::clamp(out.normals[index(a)].dot(out.normals[index(b)]), -1.0, 1.0));
      const auto [k, per_ratio] = couplings_.at(ratio, tilt, radius_mm, trace_mm);
      out.pairs.push_back({a, b, ratio, k, per_ratio, weight_of(ratio)});
    }
  return out;
}

double Relaxation::cost(const State& state) const {
  double sum = 0;
  for (const State::Pair& p : state.pairs) {
    const double weighted = p.weight * p.k, r = weighted / coupling_unit, b = weighted / coupling_bound;
    sum += r * r + std::pow(b, 6);
  }
  for (const double mm : state.outside)
    if (mm > 0) sum += mm * mm / (outside_unit_mm * outside_unit_mm);
  for (const Vector3d& place : state.places)
    if (const double mm = half_.outside_mm(place); mm > 0)
      sum += mm * mm / (outside_unit_mm * outside_unit_mm);
  for (const Centre& c : state.centres) sum += c.moved.squaredNorm() / (move_unit_mm * move_unit_mm);
  const auto count = static_cast<double>(state.centres.size());
  return sum + count * state.drift().squaredNorm() / (drift_unit_mm * drift_unit_mm);
}

Relaxation::Normal Relaxation::linearised(const State& state) const {
  const InkedSurface& surface = charted_->surface();
  const Index size = 2 * static_cast<Index>(state.centres.size());
  Normal out{MatrixXd::Zero(size, size), VectorXd::Zero(size)};
  const auto in_frame = [&](int i, const Vector3d& direction) {
    const Centre& c = state.centres[index(i)];
    return Vector2d(direction.dot(c.axis), direction.dot(surface.normal(c.point.triangle).cross(c.axis)));
  };
  for (const State::Pair& p : state.pairs) {
    if (p.k == 0) continue;
    const Vector3d way = (state.places[index(p.b)] - state.places[index(p.a)]).normalized();
    const double per_mm = p.weight * p.per_ratio / (2 * state.radius_mm), b = p.weight * p.k / coupling_bound;
    const Vector2d of_a = -per_mm * in_frame(p.a, way), of_b = per_mm * in_frame(p.b, way);
    const double cube = b * b * b, slope = 3 * b * b / coupling_bound;
    const double pull = p.weight * p.k / (coupling_unit * coupling_unit) + cube * slope;
    const double stiffness = 1 / (coupling_unit * coupling_unit) + slope * slope;
    out.b.segment<2>(2 * p.a) -= pull * of_a;
    out.b.segment<2>(2 * p.b) -= pull * of_b;
    out.A.block<2, 2>(2 * p.a, 2 * p.a) += stiffness * of_a * of_a.transpose();
    out.A.block<2, 2>(2 * p.b, 2 * p.b) += stiffness * of_b * of_b.transpose();
    out.A.block<2, 2>(2 * p.a, 2 * p.b) += stiffness * of_a * of_b.transpose();
    out.A.block<2, 2>(2 * p.b, 2 * p.a) += stiffness * of_b * of_a.transpose();
  }
  // The drift's change with each move.
  Eigen::Matrix3Xd drifts(3, size);
  for (Index i = 0; i < size / 2; ++i) {
    const Centre& c = state.centres[index(i)];
    const Vector3d across = surface.normal(c.point.triangle).cross(c.axis);
    drifts.col(2 * i) = state.along(c.axis), drifts.col(2 * i + 1) = state.along(across);
  }
  const double unit_drift = drift_unit_mm * drift_unit_mm, count = static_cast<double>(size) / 2;
  out.A += drifts.transpose() * drifts / (unit_drift * count);
  out.b -= drifts.transpose() * state.drift() / unit_drift;
  for (int i = 0; i < size / 2; ++i) {
    const double unit = move_unit_mm * move_unit_mm;
    out.b.segment<2>(2 * i) -= state.centres[index(i)].moved / unit;
    out.A.diagonal().segment<2>(2 * i).array() += 1 / unit;
    const auto keep_in = [&](double mm, const Vector3d& inward) {
      if (mm <= 0) return;
      const Vector2d slope = -in_frame(i, inward) / outside_unit_mm;
      out.b.segment<2>(2 * i) -= mm / outside_unit_mm * slope;
      out.A.block<2, 2>(2 * i, 2 * i) += slope * slope.transpose();
    };
    keep_in(state.outside[index(i)], state.inward[index(i)]);
    keep_in(half_.outside_mm(state.places[index(i)]), Vector3d(0, half_.side, 0));
  }
  return out;
}

// After a step, of which no move is longer than a part of the radius.
Relaxation::State Relaxation::moved(const State& from, const VectorXd& step) const {
  const double longest_mm = 0.15 * from.radius_mm;
  std::vector<Centre> centres = from.centres;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    Vector2d by = step.segment<2>(2 * static_cast<Index>(i));
    if (by.norm() > longest_mm) by *= longest_mm / by.norm();
    move(charted_->surface(), centres[i], by);
  }
  State out = state(std::move(centres), from.radius_mm, from.trace_mm);
  out.about = from.about;
  return out;
}

Arrangement Relaxation::arrangement(State state) {
  Arrangement out;
  out.centres = std::move(state.centres), out.radius_mm = state.radius_mm;
  double squares = 0;
  for (const State::Pair& p : state.pairs) {
    squares += p.k * p.k;
    const bool overlap = p.ratio < overlapping_ratio;
    out.overlaps += overlap;
    double& worst = overlap ? out.overlapping : out.apart;
    worst = std::max(worst, std::abs(p.k));
  }
  out.rms = state.pairs.empty() ? 0 : std::sqrt(squares / static_cast<double>(state.pairs.size()));
  for (const double mm : state.outside) out.outside_mm = std::max(out.outside_mm, mm);
  out.drift_mm = state.drift().norm();
  for (Centre& c : out.centres) c.moved.setZero();
  return out;
}

Middle Relaxation::middle_of(const std::vector<Centre>& centres, double radius_mm) const {
  const State at = state(centres, radius_mm, 0);
  return {mean_of(at.places), mean_of(at.normals).normalized()};
}

Arrangement Relaxation::relaxed(std::vector<Centre> centres, double radius_mm, double trace_mm,
                                const Middle& about) const {
  constexpr int most_steps = 60;
  constexpr double most_damping = 1e5, least_gain = 2e-3;
  for (Centre& c : centres) c.moved.setZero();
  State now = state(std::move(centres), radius_mm, trace_mm);
  now.about = about;
  double cost_now = cost(now), damping = 1e-2, gain = 1;
  for (int step = 0; step < most_steps && gain > least_gain; ++step) {
    const Normal normal = linearised(now);
    gain = 0;
    for (bool first = true; gain == 0 && damping < most_damping; first = false) {
      MatrixXd damped = normal.A;
      damped.diagonal() *= 1 + damping;
      State next = moved(now, solve_symmetric(damped, normal.b));
      if (const double cost_next = cost(next); cost_next < cost_now) {
        gain = 1 - cost_next / cost_now;
        now = std::move(next), cost_now = cost_next;
        if (first) damping = std::max(1e-6, damping / 10);
      } else {
        damping *= 10;
      }
    }
  }
  return arrangement(std::move(now));
}

}  // namespace vacuform
