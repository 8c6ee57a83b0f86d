#include "worker/coils/decoupling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/coils/inductance.hpp"
#include "worker/numerics/dense.hpp"
#include "worker/stage/batches.hpp"
#include "worker/stage/index.hpp"

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
constexpr double least_inside_mm = 1, unit_border_mm = 0.1;
constexpr double off_weight = 0.1;  // of pairs of which one is off the head
// Of loops that no overlap can decouple: those whose centres are farther apart than `side_by_side` times their radii
// together.
constexpr double far_weight = 0.25, side_by_side = 1.1;
constexpr double most_apart = 2.3;  // farther loops couple by less than 0.004
constexpr double thin_from = 1.3;   // half of the points do for loops so far apart

// A loop by a coarse polar grid, and by half and a quarter of its points: good enough for steps.
struct Wire {
  std::vector<Vector3d> line, thin;
  double self_nh = 0;
  double to_border = 0;  // of the line, mm; negative off the chart
};

double distance_to(const std::vector<Vector3d>& border, const Vector3d& place) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3d& b : border) least = std::min(least, (place - b).squaredNorm());
  return std::sqrt(least);
}

constexpr double step_mm = 0.5, step_size = 0.01;  // of derivatives

struct Sketch {
  Wire wire, larger;
  bool on_head = true;
};

// The coupling of two wires; NaN where one runs off the sheet.
double coupling(const Wire& a, const Wire& b, bool thin) {
  if (a.line.empty() || b.line.empty()) return std::numeric_limits<double>::quiet_NaN();
  return mutual_inductance_nh(thin ? a.thin : a.line, thin ? b.thin : b.line) /
         std::sqrt(a.self_nh * b.self_nh);
}

class Decoupling {
 public:
  Decoupling(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
             double size_limit, const Context& context)
      : charted_(charted),
        layout_(layout),
        laid_(laid),
        limit_(size_limit),
        context_(context),
        border_(charted.border()) {
    for (const Centre& c : layout.centres) start_.push_back(c.moved);
    for (std::size_t i = 0; i < laid.size(); ++i)
      if (!laid[i].element.loop.empty()) coils_.push_back(i);
    unknown_.assign(laid.size(), -1);
    for (const std::size_t i : coils_)
      if (layout.elements[i].leader < 0) unknown_[i] = unknowns_++;
  }

  // Steps are taken on sketches of the loops, whose couplings are corrected by what they are wrong where the steps begin.
  // Farther on they are wrong by something else: so of the way that they lead, as much is taken as makes the real layout
  // better, and it is done again from there.
  Result<void> run() {
    if (coils_.size() > most_coupled_coils) return {};
    constexpr int most_passes = 3;
    constexpr double least_gain = 0.05;
    for (int pass = 0; pass < most_passes && unknowns_ > 0; ++pass) {
      VACUFORM_TRY(begin, sketched(layout_));
      find_pairs(begin);
      guard(begin);
      VACUFORM_TRY(before, judged());
      if (pairs_.empty() || before.worst <= good_k) return {};
      VACUFORM_CHECK(correct(begin));
      const ElementLayout from = layout_;
      const std::vector<LaidCoil> from_laid = laid_;
      VACUFORM_CHECK(improve_or_give_up(std::move(begin)));
      const ElementLayout to = layout_;
      Judged now = before;
      bool better = false;
      for (double part = 1; !better && part > 0.1; part /= 2) {
        layout_ = between(from, to, part);
        VACUFORM_TRY(fine, lay_coils(charted_, layout_, context_));
        laid_ = std::move(fine);
        VACUFORM_TRY(judgement, judged());
        now = judgement;
        better = now.cost < before.cost && now.strongest <= std::max(before.strongest, unnulled_k);
      }
      if (!better) {
        layout_ = from, laid_ = from_laid;
        return {};
      }
      if (now.cost > (1 - least_gain) * before.cost) return {};
    }
    return {};
  }

 private:
  struct Pair {
    std::size_t a = 0, b = 0;
    bool thin = false;
    double correction = 0;
  };
  struct Judged {
    double cost = 0, worst = 0, strongest = 0;  // worst: weighted; strongest: of two loops on the head
  };

  // Calls work(p) for every pair, and work(i) for every element that is a coil.
  template <class Work>
  Result<void> for_pairs(const Work& work) const {
    return in_batches(pairs_.size(), 64, Stage::printing, context_.silent(), work);
  }
  template <class Work>
  Result<void> for_coils(const Work& work) const {
    return in_batches(coils_.size(), 16, Stage::printing, context_.silent(),
                      [&](std::size_t c) { work(coils_[c]); });
  }

  std::size_t owner(std::size_t i) const {
    return layout_.elements[i].leader < 0 ? i : index(layout_.elements[i].leader);
  }

  // The pairs whose coupling counts, by where their loops are now.
  void find_pairs(const std::vector<Sketch>& sketches) {
    pairs_.clear();
    for (const std::size_t a : coils_)
      for (const std::size_t b : coils_) {
        if (b <= a || owner(a) == owner(b) || sketches[a].wire.line.empty() || sketches[b].wire.line.empty())
          continue;
        const double ratio = distance_ratio(a, b);
        if (ratio < most_apart) pairs_.push_back({a, b, ratio > thin_from, 0});
      }
  }

  void guard(const std::vector<Sketch>& sketches) {
    constexpr double nearly_mm = 2;
    guarded_.assign(sketches.size(), 0);
    for (const std::size_t i : coils_) guarded_[i] = sketches[i].wire.to_border > -nearly_mm;
  }

  // The distance of two centres over the radii together.
  double distance_ratio(std::size_t a, std::size_t b) const {
    const auto place = [&](std::size_t i) { return charted_.surface().place(layout_.centres[i].point); };
    const auto radius = [&](std::size_t i) {
      return layout_.elements[i].size * layout_.elements[i].outline.radius_mm;
    };
    return (place(a) - place(b)).norm() / (radius(a) + radius(b));
  }

  VectorXd weights() const {
    VectorXd out(static_cast<Index>(pairs_.size()));
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const Pair& pair = pairs_[p];
      const double aside = std::clamp(
          (distance_ratio(pair.a, pair.b) - overlap_share) / (side_by_side - overlap_share), 0.0, 1.0);
      const double on = guarded_[pair.a] && guarded_[pair.b] ? 1 : off_weight;
      out[static_cast<Index>(p)] = on * (1 + (far_weight - 1) * aside);
    }
    return out;
  }

  // Of the layout as it is really laid.
  Result<Judged> judged() const {
    VectorXd k(static_cast<Index>(pairs_.size()));
    VACUFORM_CHECK(for_pairs([&](std::size_t p) {
      k[static_cast<Index>(p)] = vacuform::coupling(laid_[pairs_[p].a], laid_[pairs_[p].b])
                                     .value_or(std::numeric_limits<double>::infinity());
    }));
    const VectorXd w = weights();
    Judged out{cost_of(k, w), worst(k, w), 0};
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      if (laid_[pairs_[p].a].element.on_head && laid_[pairs_[p].b].element.on_head)
        out.strongest = std::max(out.strongest, std::abs(k[static_cast<Index>(p)]));
    return out;
  }

  Result<void> correct(const std::vector<Sketch>& sketches) {
    return for_pairs([&](std::size_t p) {
      Pair& pair = pairs_[p];
      pair.correction = vacuform::coupling(laid_[pair.a], laid_[pair.b]).value_or(0) -
                        coupling(sketches[pair.a].wire, sketches[pair.b].wire, pair.thin);
    });
  }

  // A part of the way from one layout to another.
  ElementLayout between(const ElementLayout& begin, const ElementLayout& end, double part) const {
    if (part == 1) return end;
    ElementLayout out = begin;
    for (std::size_t i = 0; i < out.centres.size(); ++i) {
      if (out.elements[i].leader >= 0) continue;
      move(charted_.surface(), out.centres[i], part * (end.centres[i].moved - begin.centres[i].moved));
      out.elements[i].size += part * (end.elements[i].size - begin.elements[i].size);
    }
    follow_leaders(charted_, out);
    return out;
  }

  // Better the whole array elsewhere than coupled.
  Result<void> improve_or_give_up(std::vector<Sketch> sketches) {
    VACUFORM_CHECK(improve(sketches));
    VACUFORM_TRY(k, couplings(sketches));
    if (array_weight_ == 0 || worst(k, weights()) <= required_k) return {};
    array_weight_ = 0;
    return improve(sketches);
  }

  Result<void> improve(std::vector<Sketch>& sketches) {
    constexpr int most_steps = 12;
    constexpr double most_damping = 1e4, least_gain = 0.01;
    double damping = 1e-3, gain = 1;
    VACUFORM_TRY(k, couplings(sketches));
    for (int step = 0; step < most_steps && gain > least_gain; ++step) {
      const VectorXd w = weights();
      if (worst(k, w) <= good_k) break;
      VACUFORM_TRY(J, jacobian(sketches));
      const ElementLayout before = layout_;
      const double cost = cost_of(k, w) + border_cost(sketches);
      gain = 0;
      for (bool first = true; gain == 0 && damping < most_damping; first = false) {
        VACUFORM_TRY(next, take(solve(J, k, w, damping, sketches), before, sketches));
        VACUFORM_TRY(k_next, couplings(next));
        if (const double cost_next = cost_of(k_next, weights()) + border_cost(next);
            k_next.allFinite() && cost_next < cost) {
          gain = 1 - cost_next / cost;
          sketches = std::move(next);
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

  // The fourth power's residual of a weighted k, and its slope.
  static std::pair<double, double> beyond_bound(double k) {
    const double ratio = k / bound_k, cube = ratio * ratio * ratio;
    return {bound_weight * cube * ratio, 4 * bound_weight * cube / bound_k};
  }

  Result<VectorXd> couplings(const std::vector<Sketch>& sketches) const {
    VectorXd k(static_cast<Index>(pairs_.size()));
    VACUFORM_CHECK(for_pairs([&](std::size_t p) {
      const Pair& pair = pairs_[p];
      k[static_cast<Index>(p)] =
          coupling(sketches[pair.a].wire, sketches[pair.b].wire, pair.thin) + pair.correction;
    }));
    return k;
  }

  // How far a loop that lay on the head, or nearly so, is too near its border, in units.
  double too_near(std::size_t i, const Wire& wire) const {
    const LaidElement& e = layout_.elements[i];
    if (!guarded_[i] || wire.line.empty()) return 0;
    return std::max(0.0, e.size * e.outline.width_mm / 2 + least_inside_mm - wire.to_border) / unit_border_mm;
  }
  double border_cost(const std::vector<Sketch>& sketches) const {
    double sum = 0;
    for (const std::size_t i : coils_) {
      const double r = too_near(i, sketches[i].wire);
      sum += r * r;
    }
    return sum;
  }

  static double worst(const VectorXd& k, const VectorXd& w) {
    return k.size() == 0 ? 0 : k.cwiseProduct(w).cwiseAbs().maxCoeff();
  }

  // Unknowns: of each loop that follows no other its move along the axis and across it, mm, and its size.
  VectorXd strain() const {
    VectorXd x(3 * unknowns_);
    for (const std::size_t i : coils_) {
      if (unknown_[i] < 0) continue;
      const Vector2d moved = layout_.centres[i].moved - start_[i];
      x.segment<3>(3 * unknown_[i]) << moved.x() / unit_mm, moved.y() / unit_mm,
          (layout_.elements[i].size - 1) / unit_size;
    }
    return x;
  }

  // The sums of the moves along and across the axes: where the user laid the array, it stays.
  static Eigen::RowVector2d drift(const VectorXd& x) {
    const auto by_element = Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, x.size() / 3);
    return by_element.topRows<2>().rowwise().sum().transpose();
  }

  double cost_of(const VectorXd& k, const VectorXd& w) const {
    const VectorXd x = strain();
    double sum = x.squaredNorm() + array_weight_ / unknowns_ * drift(x).squaredNorm();
    for (Index p = 0; p < k.size(); ++p) {
      const double weighted = w[p] * k[p], r = weighted / unit_k, b = beyond_bound(weighted).first;
      sum += r * r + b * b;
    }
    return sum;
  }

  PolarGrid grid(const ElementLayout& layout, std::size_t i, const Vector2d& by) const {
    constexpr int directions = 64;
    Centre centre = layout.centres[i];
    move(charted_.surface(), centre, by);
    const LaidElement& e = layout.elements[i];
    const double reach = 1.08 * (1 + limit_) * e.size * e.outline.reach_mm + 1;
    return PolarGrid(charted_, centre.point,
                     turned(charted_.surface(), centre.point.triangle, centre.axis, laid_[i].element.turn),
                     reach, layout.keep, directions);
  }

  Wire wire(const PolarGrid& grid, const LaidElement& element, double size) const {
    LaidElement coarse{element.element, {}, size};
    for (std::size_t i = 0; i < element.outline.loop.size(); i += 2)
      coarse.outline.loop.push_back(element.outline.loop[i]);
    Wire out;
    out.line = loop_in_space(grid, coarse);
    for (std::size_t i = 0; i < out.line.size(); i += 2) out.thin.push_back(out.line[i]);
    if (out.line.empty()) return out;
    out.self_nh = self_inductance_nh(out.line, size * element.outline.width_mm);
    out.to_border = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < out.line.size(); ++i) {
      const double mm = distance_to(border_, out.line[i]);
      out.to_border = std::min(out.to_border, grid.on_chart(size * coarse.outline.loop[i]) ? mm : -mm);
    }
    return out;
  }

  Sketch sketch(const ElementLayout& layout, std::size_t i) const {
    const PolarGrid at = grid(layout, i, {0, 0});
    const LaidElement& e = layout.elements[i];
    Sketch out{wire(at, e, e.size), wire(at, e, e.size + step_size), true};
    out.on_head = std::all_of(e.outline.points.begin(), e.outline.points.end(),
                              [&](const Vector2d& p) { return at.on_chart(e.size * p); });
    return out;
  }

  // By element; of coils alone.
  Result<std::vector<Sketch>> sketched(const ElementLayout& layout) const {
    VACUFORM_CHECK(context_.step(Stage::printing, 0));
    std::vector<Sketch> out(layout.elements.size());
    VACUFORM_CHECK(for_coils([&](std::size_t i) { out[i] = sketch(layout, i); }));
    return out;
  }

  // The change of every pair's k with the unknowns of its two owners, in their units, by differences.
  struct Slopes {
    std::vector<std::array<Vector3d, 2>> of_k;  // by pair, of its two owners' unknowns
    std::vector<Vector3d> of_border;            // by element, of too_near()
  };
  Result<Slopes> jacobian(const std::vector<Sketch>& sketches) const {
    std::vector<std::array<Wire, 2>> moved(sketches.size());
    VACUFORM_CHECK(context_.step(Stage::printing, 0));
    VACUFORM_CHECK(for_coils([&](std::size_t i) {
      const LaidElement& e = layout_.elements[i];
      moved[i] = {wire(grid(layout_, i, {step_mm, 0}), e, e.size),
                  wire(grid(layout_, i, {0, step_mm}), e, e.size)};
    }));
    Slopes out{std::vector<std::array<Vector3d, 2>>(pairs_.size()),
               std::vector<Vector3d>(sketches.size(), Vector3d::Zero())};
    for (const std::size_t i : coils_) {
      if (unknown_[i] < 0 || too_near(i, sketches[i].wire) == 0) continue;
      const auto with = [&](const Wire& changed) {
        return changed.line.empty() ? 0 : (sketches[i].wire.to_border - changed.to_border) / unit_border_mm;
      };
      out.of_border[i] = {with(moved[i][0]) * unit_mm / step_mm, with(moved[i][1]) * unit_mm / step_mm,
                          with(sketches[i].larger) * unit_size / step_size};
    }
    VACUFORM_CHECK(for_pairs([&](std::size_t p) {
      const Pair& pair = pairs_[p];
      const double k = coupling(sketches[pair.a].wire, sketches[pair.b].wire, pair.thin);
      const auto slopes = [&](std::size_t of, std::size_t other) {
        const auto with = [&](const Wire& changed) {
          return coupling(changed, sketches[other].wire, pair.thin) - k;
        };
        const bool follows = layout_.elements[of].leader >= 0;
        Vector3d slope{with(moved[of][0]) * unit_mm / step_mm, with(moved[of][1]) * unit_mm / step_mm,
                       follows ? 0 : with(sketches[of].larger) * unit_size / step_size};
        if (!slope.allFinite()) slope.setZero();  // beyond the sheet's border nothing can be said
        return slope;
      };
      out.of_k[p] = {slopes(pair.a, pair.b), slopes(pair.b, pair.a)};
    }));
    return out;
  }

  // The damped step; sizes that would leave their bounds are put on them, and the rest is solved again.
  VectorXd solve(const Slopes& J, const VectorXd& k, const VectorXd& w, double damping,
                 const std::vector<Sketch>& sketches) const {
    const VectorXd x = strain();
    MatrixXd normal = (1 + damping) * MatrixXd::Identity(x.size(), x.size());
    VectorXd rhs = -x;
    const double per_element = array_weight_ / unknowns_;
    const Eigen::RowVector2d drifted = drift(x);
    for (Index i = 0; i < x.size(); ++i) {
      if (i % 3 == 2) continue;
      rhs[i] -= per_element * drifted[i % 3];
      for (Index j = i % 3; j < x.size(); j += 3) normal(i, j) += per_element;
    }
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const std::array<Index, 2> end{3 * unknown_[owner(pairs_[p].a)], 3 * unknown_[owner(pairs_[p].b)]};
      const Index row = static_cast<Index>(p);
      const double weighted = w[row] * k[row];
      const auto [beyond, slope] = beyond_bound(weighted);
      const double pull = w[row] * (weighted / (unit_k * unit_k) + beyond * slope);
      const double stiffness = w[row] * w[row] * (1 / (unit_k * unit_k) + slope * slope);
      for (std::size_t i = 0; i < 2; ++i) {
        rhs.segment<3>(end[i]) -= pull * J.of_k[p][i];
        normal.diagonal().segment<3>(end[i]) += damping * stiffness * J.of_k[p][i].cwiseAbs2();
        for (std::size_t j = 0; j < 2; ++j)
          normal.block<3, 3>(end[i], end[j]) += stiffness * J.of_k[p][i] * J.of_k[p][j].transpose();
      }
    }
    for (const std::size_t i : coils_) {
      if (unknown_[i] < 0) continue;
      const Vector3d& slope = J.of_border[i];
      const Index at = 3 * unknown_[i];
      rhs.segment<3>(at) -= too_near(i, sketches[i].wire) * slope;
      normal.block<3, 3>(at, at) += slope * slope.transpose();
      normal.diagonal().segment<3>(at) += damping * slope.cwiseAbs2();
    }
    const double bound = limit_ / unit_size;
    std::vector<char> held(index(unknowns_), 0);
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

  // The sketches after a step. What lay on the head and would leave it stays where it was.
  Result<std::vector<Sketch>> take(const VectorXd& step, const ElementLayout& before,
                                   const std::vector<Sketch>& sketches) {
    constexpr double longest_mm = 4;
    for (const std::size_t i : coils_) {
      if (unknown_[i] < 0) continue;
      const Vector3d d = step.segment<3>(3 * unknown_[i]);
      Vector2d by = unit_mm * d.head<2>();
      if (by.norm() > longest_mm) by *= longest_mm / by.norm();
      move(charted_.surface(), layout_.centres[i], by);
      double& size = layout_.elements[i].size;
      size = std::clamp(size + unit_size * d[2], 1 - limit_, 1 + limit_);
    }
    follow_leaders(charted_, layout_);
    VACUFORM_TRY(next, sketched(layout_));
    bool left = false;
    for (const std::size_t i : coils_) {
      if (!sketches[i].on_head || next[i].on_head) continue;
      layout_.centres[owner(i)] = before.centres[owner(i)];
      layout_.elements[owner(i)].size = before.elements[owner(i)].size;
      left = true;
    }
    if (!left) return next;
    follow_leaders(charted_, layout_);
    return sketched(layout_);
  }

  const ChartedSurface& charted_;
  ElementLayout& layout_;
  std::vector<LaidCoil>& laid_;
  double limit_;
  const Context& context_;
  std::vector<Vector3d> border_;
  std::vector<char> guarded_;       // loops that stay on the head
  std::vector<std::size_t> coils_;  // elements with a loop
  std::vector<int> unknown_;        // of each element, which loop that follows no other it is; -1: none
  int unknowns_ = 0;
  std::vector<Pair> pairs_;
  std::vector<Vector2d> start_;
  double array_weight_ = array_weight;
};

}  // namespace

Result<void> decouple(const ChartedSurface& charted, ElementLayout& layout, std::vector<LaidCoil>& laid,
                      double size_limit, const Context& context) {
  return Decoupling(charted, layout, laid, size_limit, context).run();
}

}  // namespace vacuform
