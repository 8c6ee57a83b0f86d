#include "worker/coils/decoupling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/coils/inductance.hpp"
#include "worker/numerics/dense.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double required_k = 0.0098, good_k = 1e-3;
// What weighs as much: a coupling, a move, a change of size. The first is small, so that it goes first.
constexpr double unit_k = 1e-3, unit_mm = 5, unit_size = 0.02;
// Where not every pair can be decoupled, the worst pairs count most: by the fourth power of k over this bound, too.
constexpr double bound_k = 0.008, bound_weight = 10;
constexpr double array_weight = 100;  // of a shift of the array as a whole against that of each loop
constexpr double off_weight = 0.1;    // of pairs of which one is off the head

// One element by the polar grid alone and with half of its points: good enough for differences.
LaidCoil probe(const PolarGrid& grid, const LaidElement& element, double size) {
  LaidElement coarse{element.element, {}, size};
  for (std::size_t i = 0; i < element.outline.loop.size(); i += 2)
    coarse.outline.loop.push_back(element.outline.loop[i]);
  LaidCoil out;
  out.element.loop = loop_in_space(grid, coarse);
  if (!out.element.loop.empty())
    out.self_nh = self_inductance_nh(out.element.loop, size * element.outline.width_mm);
  return out;
}

double coupling_or_nan(const LaidCoil& a, const LaidCoil& b) {
  return coupling(a, b).value_or(std::numeric_limits<double>::quiet_NaN());
}

class Decoupling {
 public:
  Decoupling(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
             double size_limit, bool halves_count, const Context& context)
      : charted_(charted),
        layout_(layout),
        laid_(laid),
        limit_(size_limit),
        halves_count_(halves_count),
        context_(context) {
    for (const Neighbours& n : layout.pairs) {
      if (!coupling(laid[index(n.a)], laid[index(n.b)])) continue;
      pairs_.push_back(n);
      weights_.push_back(std::min(weight(index(n.a)), weight(index(n.b))));
    }
    for (const Centre& c : layout.centres) start_.push_back(c.moved);
  }

  // On bumps the steps are taken on a rough layout, whose couplings are corrected by what they are wrong where the steps
  // begin. Farther on they are wrong by something else: so it is done again, and the best layout met is kept.
  Result<void> run() {
    constexpr int most_passes = 6;
    std::vector<LaidCoil> best_laid;
    ElementLayout best_layout;
    double least = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass <= most_passes; ++pass) {
      const VectorXd exact = couplings(laid_);
      if (worst(exact) >= least) break;
      least = worst(exact), best_layout = layout_, best_laid = laid_;
      if (least <= good_k || pass == most_passes) break;
      const bool bumps = !all_smooth();
      correction_ = VectorXd::Zero(exact.size());
      if (bumps) {
        VACUFORM_TRY(rough, lay_coils(charted_, layout_, context_, true));
        laid_ = std::move(rough);
        correction_ = exact - couplings(laid_);
        if (!correction_.allFinite()) correction_.setZero();
      }
      VACUFORM_CHECK(improve_or_give_up());
      if (!bumps && all_smooth()) return {};
      VACUFORM_TRY(fine, lay_coils(charted_, layout_, context_));
      laid_ = std::move(fine);
    }
    layout_ = std::move(best_layout), laid_ = std::move(best_laid);
    return {};
  }

 private:
  void drop_place() { array_weight_ = 0; }
  void drop_head() { stay_on_head_ = false; }

  // Better the whole array elsewhere than coupled, and better a loop off the head.
  Result<void> improve_or_give_up() {
    VACUFORM_CHECK(improve());
    for (const auto& give_up : {&Decoupling::drop_place, &Decoupling::drop_head})
      if (worst(corrected(laid_)) > required_k) {
        (this->*give_up)();
        VACUFORM_CHECK(improve());
      }
    return {};
  }

  Result<void> improve() {
    constexpr int most_steps = 25;
    constexpr double most_damping = 1e4, least_gain = 0.01;
    double damping = 1e-3, gain = 1;
    VectorXd k = corrected(laid_);
    for (int step = 0; step < most_steps && worst(k) > good_k && gain > least_gain; ++step) {
      VACUFORM_TRY(J, jacobian());
      const ElementLayout before = layout_;
      const double cost = cost_of(k);
      gain = 0;
      for (bool first = true; gain == 0 && damping < most_damping; first = false) {
        VACUFORM_TRY(next, take(solve(J, k, damping), before));
        const VectorXd k_next = corrected(next);
        if (k_next.allFinite() && cost_of(k_next) < cost) {
          gain = 1 - cost_of(k_next) / cost;
          laid_ = std::move(next);
          k = k_next;
          if (first) damping = std::max(1e-6, damping / 10);
        } else {
          layout_ = before;
          damping *= 10;
        }
      }
    }
    return {};
  }

  bool all_smooth() const {
    return std::all_of(laid_.begin(), laid_.end(),
                       [](const LaidCoil& coil) { return coil.element.patch.smooth; });
  }

  double weight(std::size_t i) const {
    const bool on =
        halves_count_ ? charted_.on_chart(layout_.centres[i].point.triangle) : laid_[i].element.on_head;
    return on ? 1 : off_weight;
  }

  // The fourth power's residual of a weighted k, and its slope.
  static std::pair<double, double> beyond_bound(double k) {
    const double ratio = k / bound_k, cube = ratio * ratio * ratio;
    return {bound_weight * cube * ratio, 4 * bound_weight * cube / bound_k};
  }

  VectorXd couplings(const std::vector<LaidCoil>& laid) const {
    VectorXd k(static_cast<Index>(pairs_.size()));
    in_parallel(0, static_cast<int>(pairs_.size()), [&](int first, int last) {
      for (std::size_t p = index(first); p < index(last); ++p)
        k[static_cast<Index>(p)] = coupling_or_nan(laid[index(pairs_[p].a)], laid[index(pairs_[p].b)]);
    });
    return k;
  }

  VectorXd corrected(const std::vector<LaidCoil>& laid) const { return couplings(laid) + correction_; }

  double worst(const VectorXd& k) const {
    double most = 0;
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      most = std::max(most, weights_[p] * std::abs(k[static_cast<Index>(p)]));
    return most;
  }

  // Unknowns: for each element its move along the axis and across it, mm, and its size.
  VectorXd strain() const {
    VectorXd x(3 * static_cast<Index>(start_.size()));
    for (std::size_t i = 0; i < start_.size(); ++i) {
      const Vector2d moved = layout_.centres[i].moved - start_[i];
      x.segment<3>(3 * static_cast<Index>(i)) << moved.x() / unit_mm, moved.y() / unit_mm,
          (layout_.elements[i].size - 1) / unit_size;
    }
    return x;
  }

  // The sums of the moves along and across the axes: where the user laid the array, it stays.
  static Eigen::RowVector2d drift(const VectorXd& x) {
    const auto by_element = Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, x.size() / 3);
    return by_element.topRows<2>().rowwise().sum().transpose();
  }

  double cost_of(const VectorXd& k) const {
    const VectorXd x = strain();
    double sum =
        x.squaredNorm() + array_weight_ / static_cast<double>(start_.size()) * drift(x).squaredNorm();
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const double weighted = weights_[p] * k[static_cast<Index>(p)], r = weighted / unit_k;
      const double b = beyond_bound(weighted).first;
      sum += r * r + b * b;
    }
    return sum;
  }

  PolarGrid grid(std::size_t i, const Vector2d& by) const {
    Centre centre = layout_.centres[i];
    move(charted_.surface(), centre, by);
    const LaidElement& e = layout_.elements[i];
    const double reach = 1.08 * (1 + limit_) * e.size * e.outline.reach_mm + 1;
    return PolarGrid(charted_, centre.point,
                     turned(charted_.surface(), centre.point.triangle, centre.axis, laid_[i].element.turn),
                     reach, layout_.keep);
  }

  // The change of every pair's k with the unknowns in their units, by differences; pairs' rows have six entries.
  Result<std::vector<std::array<Vector3d, 2>>> jacobian() const {
    constexpr double step_mm = 0.5, step_size = 0.01;
    const int count = static_cast<int>(layout_.elements.size());
    std::vector<LaidCoil> here(layout_.elements.size());
    std::vector<std::array<LaidCoil, 3>> changed(layout_.elements.size());
    VACUFORM_CHECK(context_.step(Stage::printing, 0));
    in_parallel(0, count, [&](int first, int last) {
      for (std::size_t i = index(first); i < index(last); ++i) {
        const LaidElement& e = layout_.elements[i];
        const PolarGrid at = grid(i, {0, 0});
        here[i] = probe(at, e, e.size);
        changed[i] = {probe(grid(i, {step_mm, 0}), e, e.size), probe(grid(i, {0, step_mm}), e, e.size),
                      probe(at, e, e.size + step_size)};
      }
    });
    VACUFORM_CHECK(context_.step(Stage::printing, 0));
    std::vector<std::array<Vector3d, 2>> J(pairs_.size());
    in_parallel(0, static_cast<int>(pairs_.size()), [&](int first, int last) {
      for (std::size_t p = index(first); p < index(last); ++p) {
        const std::size_t a = index(pairs_[p].a), b = index(pairs_[p].b);
        const double k = coupling_or_nan(here[a], here[b]);
        auto& [of_a, of_b] = J[p];
        for (int c = 0; c < 3; ++c) {
          const double per = c < 2 ? unit_mm / step_mm : unit_size / step_size;
          of_a[c] = (coupling_or_nan(changed[a][index(c)], here[b]) - k) * per;
          of_b[c] = (coupling_or_nan(here[a], changed[b][index(c)]) - k) * per;
        }
        // Beyond the sheet's border nothing can be said.
        if (!of_a.allFinite()) of_a.setZero();
        if (!of_b.allFinite()) of_b.setZero();
      }
    });
    return J;
  }

  // The damped step; sizes that would leave their bounds are put on them, and the rest is solved again.
  VectorXd solve(const std::vector<std::array<Vector3d, 2>>& J, const VectorXd& k, double damping) const {
    const VectorXd x = strain();
    MatrixXd normal = (1 + damping) * MatrixXd::Identity(x.size(), x.size());
    VectorXd rhs = -x;
    const double per_element = array_weight_ / static_cast<double>(start_.size());
    const Eigen::RowVector2d drifted = drift(x);
    for (Index i = 0; i < x.size(); ++i) {
      if (i % 3 == 2) continue;
      rhs[i] -= per_element * drifted[i % 3];
      for (Index j = i % 3; j < x.size(); j += 3) normal(i, j) += per_element;
    }
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const std::array<int, 2> end{3 * pairs_[p].a, 3 * pairs_[p].b};
      const double w = weights_[p], weighted = w * k[static_cast<Index>(p)];
      const auto [beyond, slope] = beyond_bound(weighted);
      const double pull = w * (weighted / (unit_k * unit_k) + beyond * slope);
      const double stiffness = w * w * (1 / (unit_k * unit_k) + slope * slope);
      for (std::size_t i = 0; i < 2; ++i) {
        rhs.segment<3>(end[i]) -= pull * J[p][i];
        normal.diagonal().segment<3>(end[i]) += damping * stiffness * J[p][i].cwiseAbs2();
        for (std::size_t j = 0; j < 2; ++j)
          normal.block<3, 3>(end[i], end[j]) += stiffness * J[p][i] * J[p][j].transpose();
      }
    }
    const double bound = limit_ / unit_size;
    std::vector<char> held(start_.size(), 0);
    VectorXd step;
    for (bool again = true; again;) {
      step = solve_symmetric(normal, rhs);
      again = false;
      for (std::size_t i = 0; i < held.size(); ++i) {
        const Index s = 3 * static_cast<Index>(i) + 2;
        const double to = std::clamp(x[s] + step[s], -bound, bound);
        if (held[i] || to == x[s] + step[s]) continue;
        held[i] = again = true;
        rhs -= normal.col(s) * (to - x[s]);
        normal.row(s).setZero();
        normal.col(s).setZero();
        normal(s, s) = 1;
        rhs[s] = to - x[s];
      }
    }
    return step;
  }

  // The layout after a step. What lay on the head and would leave it stays where it was.
  Result<std::vector<LaidCoil>> take(const VectorXd& step, const ElementLayout& before) {
    constexpr double longest_mm = 4;
    for (std::size_t i = 0; i < start_.size(); ++i) {
      const Vector3d d = step.segment<3>(3 * static_cast<Index>(i));
      Vector2d by = unit_mm * d.head<2>();
      if (by.norm() > longest_mm) by *= longest_mm / by.norm();
      move(charted_.surface(), layout_.centres[i], by);
      double& size = layout_.elements[i].size;
      size = std::clamp(size + unit_size * d[2], 1 - limit_, 1 + limit_);
    }
    VACUFORM_TRY(next, lay_coils(charted_, layout_, context_, true));
    bool left = false;
    for (std::size_t i = 0; i < next.size() && stay_on_head_; ++i) {
      if (!laid_[i].element.on_head || next[i].element.on_head) continue;
      layout_.centres[i] = before.centres[i];
      layout_.elements[i].size = before.elements[i].size;
      left = true;
    }
    if (!left) return next;
    return lay_coils(charted_, layout_, context_, true);
  }

  const ChartedSurface& charted_;
  ElementLayout& layout_;
  std::vector<LaidCoil>& laid_;
  double limit_;
  bool halves_count_;  // loops that lie on the head in part alone
  const Context& context_;
  std::vector<Neighbours> pairs_;
  std::vector<double> weights_;
  std::vector<Vector2d> start_;
  bool stay_on_head_ = true;
  double array_weight_ = array_weight;
  VectorXd correction_;  // of the couplings of the layout that steps are taken on
};

// The largest |k| of two loops that both lie on the head.
double worst_on_head(const ElementLayout& layout, const std::vector<LaidCoil>& laid) {
  double most = 0;
  for (const Neighbours& n : layout.pairs)
    if (laid[index(n.a)].element.on_head && laid[index(n.b)].element.on_head)
      most = std::max(most, std::abs(coupling(laid[index(n.a)], laid[index(n.b)]).value_or(0)));
  return most;
}

}  // namespace

Result<void> decouple(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
                      double size_limit, const Context& context) {
  const ElementLayout layout_before = layout;
  std::vector<LaidCoil> laid_before = laid;
  VACUFORM_CHECK(Decoupling(charted, layout, laid, size_limit, true, context).run());
  if (worst_on_head(layout, laid) <= required_k) return {};
  // Loops at the foot of the mold, where the sheet is in folds, may be what holds the others back.
  ElementLayout other = layout_before;
  VACUFORM_CHECK(Decoupling(charted, other, laid_before, size_limit, false, context).run());
  if (worst_on_head(other, laid_before) < worst_on_head(layout, laid))
    layout = std::move(other), laid = std::move(laid_before);
  return {};
}

}  // namespace vacuform
