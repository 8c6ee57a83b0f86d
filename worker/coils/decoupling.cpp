#include "worker/coils/decoupling.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/coils/inductance.hpp"

namespace vacuform {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double good_k = 1e-3;
// What weighs as much: a coupling, a move, a change of size. The first is small, so that it goes first.
constexpr double unit_k = 1e-3, unit_mm = 5, unit_size = 0.02;
constexpr double beside_head = 0.2;  // weight of pairs of which one lies off the head

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// The loop of one element with its own inductance, by the polar grid alone.
struct Probe {
  std::vector<Vector3d> loop;
  double self_nh = 0;
};

Probe probe(const PolarGrid& grid, const LaidElement& element, double size) {
  LaidElement resized = element;
  resized.size = size;
  Probe out{loop_in_space(grid, resized), 0};
  if (!out.loop.empty()) out.self_nh = self_inductance_nh(out.loop, size * element.outline.width_mm);
  return out;
}

double coupling(const Probe& a, const Probe& b) {
  return mutual_inductance_nh(a.loop, b.loop) / std::sqrt(a.self_nh * b.self_nh);
}

class Decoupling {
 public:
  Decoupling(const InkedSurface& surface, ElementLayout& layout, std::vector<ElementOnSurface>& laid,
             double size_limit, const Context& context)
      : surface_(surface), layout_(layout), laid_(laid), limit_(size_limit), context_(context) {
    for (const Neighbours& n : layout.pairs) {
      if (!coupling(laid[index(n.a)], laid[index(n.b)])) continue;
      pairs_.push_back(n);
      weights_.push_back(laid[index(n.a)].on_head && laid[index(n.b)].on_head ? 1 : beside_head);
    }
    for (const Centre& c : layout.centres) start_.push_back(c.moved);
  }

  Result<void> run() {
    constexpr int most_steps = 25;
    constexpr double most_damping = 1e4;
    double damping = 1e-3;
    VectorXd k = couplings(laid_);
    for (int step = 0; step < most_steps && worst(k) > good_k && damping < most_damping; ++step) {
      VACUFORM_TRY(J, jacobian());
      for (bool better = false; !better && damping < most_damping;) {
        const ElementLayout before = layout_;
        const double cost = cost_of(k);
        take(solve(J, k, damping));
        VACUFORM_TRY(next, lay_on_surface(surface_, layout_, context_));
        const VectorXd k_next = couplings(next);
        better = k_next.allFinite() && cost_of(k_next) < cost;
        if (better) {
          gain_ = 1 - cost_of(k_next) / cost;
          laid_ = std::move(next);
          k = k_next;
          damping = std::max(1e-6, damping / 10);
        } else {
          layout_ = before;
          damping *= 10;
        }
      }
      if (gain_ < 1e-3) break;
    }
    return {};
  }

 private:
  VectorXd couplings(const std::vector<ElementOnSurface>& laid) const {
    VectorXd k(static_cast<Index>(pairs_.size()));
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      k[static_cast<Index>(p)] = vacuform::coupling(laid[index(pairs_[p].a)], laid[index(pairs_[p].b)])
                                     .value_or(std::numeric_limits<double>::quiet_NaN());
    return k;
  }

  double worst(const VectorXd& k) const {
    double most = 0;
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      if (weights_[p] == 1) most = std::max(most, std::abs(k[static_cast<Index>(p)]));
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

  double cost_of(const VectorXd& k) const {
    double sum = strain().squaredNorm();
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const double r = weights_[p] * k[static_cast<Index>(p)] / unit_k;
      sum += r * r;
    }
    return sum;
  }

  PolarGrid grid(std::size_t i, const Vector2d& by) const {
    Centre centre = layout_.centres[i];
    move(surface_, centre, by);
    const LaidElement& e = layout_.elements[i];
    const double reach = 1.08 * (1 + limit_) * e.size * e.outline.reach_mm + 1;
    return PolarGrid(surface_, centre.point,
                     turned(surface_, centre.point.triangle, centre.axis, laid_[i].turn), reach);
  }

  // The change of every pair's k with the unknowns in their units, by differences; pairs' rows have six entries.
  Result<std::vector<std::array<Vector3d, 2>>> jacobian() const {
    constexpr double step_mm = 0.5, step_size = 0.01;
    std::vector<Probe> here;
    std::vector<std::array<Probe, 3>> changed;
    for (std::size_t i = 0; i < layout_.elements.size(); ++i) {
      VACUFORM_CHECK(context_.step(Stage::printing, 0));
      const LaidElement& e = layout_.elements[i];
      const PolarGrid at = grid(i, {0, 0});
      here.push_back(probe(at, e, e.size));
      changed.push_back({probe(grid(i, {step_mm, 0}), e, e.size), probe(grid(i, {0, step_mm}), e, e.size),
                         probe(at, e, e.size + step_size)});
    }
    std::vector<std::array<Vector3d, 2>> J;
    for (const Neighbours& n : pairs_) {
      VACUFORM_CHECK(context_.step(Stage::printing, 0));
      const std::size_t a = index(n.a), b = index(n.b);
      const double k = coupling(here[a], here[b]);
      std::array<Vector3d, 2> rows;
      for (int c = 0; c < 3; ++c) {
        const double per = c < 2 ? unit_mm / step_mm : unit_size / step_size;
        rows[0][c] = (coupling(changed[a][index(c)], here[b]) - k) * per;
        rows[1][c] = (coupling(here[a], changed[b][index(c)]) - k) * per;
      }
      // Beyond the sheet's border nothing can be said.
      if (!rows[0].allFinite()) rows[0].setZero();
      if (!rows[1].allFinite()) rows[1].setZero();
      J.push_back(rows);
    }
    return J;
  }

  // The damped step; sizes that would leave their bounds are put on them, and the rest is solved again.
  VectorXd solve(const std::vector<std::array<Vector3d, 2>>& J, const VectorXd& k, double damping) const {
    const VectorXd x = strain();
    MatrixXd normal = (1 + damping) * MatrixXd::Identity(x.size(), x.size());
    VectorXd rhs = -x;
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const std::array<int, 2> end{3 * pairs_[p].a, 3 * pairs_[p].b};
      const double w = weights_[p] / unit_k;
      for (std::size_t i = 0; i < 2; ++i) {
        const Vector3d ri = w * J[p][i];
        rhs.segment<3>(end[i]) -= w * k[static_cast<Index>(p)] * ri;
        normal.diagonal().segment<3>(end[i]) += damping * ri.cwiseAbs2();
        for (std::size_t j = 0; j < 2; ++j)
          normal.block<3, 3>(end[i], end[j]) += ri * (w * J[p][j]).transpose();
      }
    }
    const double bound = limit_ / unit_size;
    std::vector<char> held(start_.size(), 0);
    VectorXd step;
    for (bool again = true; again;) {
      step = normal.ldlt().solve(rhs);
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

  void take(const VectorXd& step) {
    constexpr double longest_mm = 4;
    for (std::size_t i = 0; i < start_.size(); ++i) {
      const Vector3d d = step.segment<3>(3 * static_cast<Index>(i));
      Vector2d by = unit_mm * d.head<2>();
      if (by.norm() > longest_mm) by *= longest_mm / by.norm();
      move(surface_, layout_.centres[i], by);
      double& size = layout_.elements[i].size;
      size = std::clamp(size + unit_size * d[2], 1 - limit_, 1 + limit_);
    }
  }

  const InkedSurface& surface_;
  ElementLayout& layout_;
  std::vector<ElementOnSurface>& laid_;
  double limit_;
  const Context& context_;
  std::vector<Neighbours> pairs_;
  std::vector<double> weights_;
  std::vector<Vector2d> start_;
  double gain_ = 1;
};

}  // namespace

Result<void> decouple(const InkedSurface& surface, ElementLayout& layout, std::vector<ElementOnSurface>& laid,
                      double size_limit, const Context& context) {
  return Decoupling(surface, layout, laid, size_limit, context).run();
}

}  // namespace vacuform
