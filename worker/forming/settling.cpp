#include "worker/forming/settling.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace vacuform {

namespace {

// Work after which progress is reported and the cancellation looked at, in springs.
constexpr long springs_between_reports = 2'000'000;

double largest(const Points& columns, int count) {
  return count == 0 ? 0 : std::sqrt(columns.leftCols(count).colwise().squaredNorm().maxCoeff());
}

}  // namespace

// The net on its way, and what one step needs of the step before.
struct Settling::Motion {
  Motion(const SpringNet& moved, Points& place, const Load& carried, const Context& listener, double fraction)
      : net(moved),
        x(place),
        load(carried),
        context(listener),
        done(fraction),
        n(moved.moving()),
        mass(moved.mass()),
        v(Points::Zero(3, moved.vertices())) {}

  Result<void> worked() {
    work += static_cast<long>(net.springs().size());
    if (work < springs_between_reports) return {};
    work = 0;
    return context.step(Stage::forming, done);
  }

  // Twice the frequency of the motion, from the force that it makes for itself: `against` is -df/dx v.
  template <class Against>
  double critical_drag(const Against& against) const {
    double stiff = 0, inert = 0;
    for (int i = 0; i < n; ++i) {
      stiff += v.col(i).dot(against(i));
      inert += mass[i] * v.col(i).squaredNorm();
    }
    return inert > 0 ? 2 * std::sqrt(std::max(0.0, stiff / inert)) : 0;
  }

  double kinetic() const {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += 0.5 * mass[i] * v.col(i).squaredNorm();
    return sum;
  }

  const SpringNet& net;
  Points& x;
  const Load& load;
  const Context& context;
  double done;
  int n;
  const std::vector<double>& mass;
  Points v, f, f_before;
  long work = 0;
  // Of the linear system, allocated once.
  Points r, z, d, q, dv;
};

Result<Settling::Outcome> Settling::settle(const SpringNet& part, Points& x, const Load& load,
                                           const Context& context, double done) const {
  constexpr double safe = 0.8, large = 300, net_time_ms = 5000;
  constexpr int least_limit = 2000;
  constexpr double torn = 1e6;  // N: far beyond any force that a sheet bears

  Outcome out;
  const double limit = 2 / SpringNet::Jacobian(part, x, load.pressure).highest_frequency();
  const bool explicitly = integrator_ == Integrator::verlet;
  out.step_ms = step_ms_.value_or((explicitly ? safe : large) * limit);
  const auto most_steps = least_limit + static_cast<int>(std::min(1e8, net_time_ms / out.step_ms));
  const double motion_limit = 0.01 * longest_move_ * tolerance_ * part.moving();

  Motion motion(part, x, load, context, done);
  for (;; ++out.steps) {
    part.forces(x, motion.v, load.pressure, load.gravity, motion.f);
    out.residual = largest(motion.f, motion.n);
    out.kinetic = motion.kinetic();
    out.blew_up = !(out.residual < torn);
    out.at_rest = out.residual <= tolerance_ && out.kinetic <= motion_limit;
    if (out.blew_up || out.at_rest || out.steps == most_steps) return out;
    VACUFORM_CHECK(motion.worked());
    VACUFORM_CHECK(explicitly ? verlet(motion, out.step_ms) : implicit_euler(motion, out.step_ms));
  }
}

// Leapfrog with the drag centred: v at half steps, x at whole ones.
Result<void> Settling::verlet(Motion& m, double dt) const {
  const double drag = m.f_before.size() == 0
                          ? 0
                          : m.critical_drag([&](int i) { return (m.f_before.col(i) - m.f.col(i)) / dt; });
  const double keep = (1 - 0.5 * drag * dt) / (1 + 0.5 * drag * dt), push = dt / (1 + 0.5 * drag * dt);
  for (int i = 0; i < m.n; ++i) {
    m.v.col(i) = keep * m.v.col(i) + (push / m.mass[i]) * m.f.col(i);
    m.x.col(i) += dt * m.v.col(i);
  }
  m.f_before.swap(m.f);
  return {};
}

Result<void> Settling::implicit_euler(Motion& m, double dt) const {
  constexpr double enough = 0.1;  // of the preconditioned right-hand side: later steps correct the rest
  constexpr int most = 1000;
  const int n = m.n, others = m.net.vertices() - n;
  const SpringNet::Jacobian jacobian(m.net, m.x, m.load.pressure);
  jacobian.multiply(m.v, -1, 0, m.q);
  const double drag = m.critical_drag([&](int i) { return m.q.col(i); });

  // The system A dv = r, with the drag in A and r.
  m.r = dt * (m.f - dt * m.q);
  for (int i = 0; i < n; ++i) m.r.col(i) -= dt * drag * m.mass[i] * m.v.col(i);
  m.r.rightCols(others).setZero();
  std::vector<Eigen::Matrix3d> inverse = jacobian.diagonal(-dt * dt, -dt);
  for (int i = 0; i < n; ++i) {
    inverse[i].diagonal().array() += (1 + dt * drag) * m.mass[i];
    inverse[i] = inverse[i].inverse().eval();
  }
  const auto precondition = [&] {
    double product = 0;
    for (int i = 0; i < n; ++i) {
      m.z.col(i) = inverse[i] * m.r.col(i);
      product += m.z.col(i).dot(m.r.col(i));
    }
    return product;
  };

  m.dv.setZero(3, n + others);
  m.z.setZero(3, n + others);
  double rho = precondition();
  const double target = enough * enough * rho;
  m.d = m.z;
  for (int k = 0; k < most && rho > target; ++k) {
    VACUFORM_CHECK(m.worked());
    jacobian.multiply(m.d, -dt * dt, -dt, m.q);
    double curvature = 0;
    for (int i = 0; i < n; ++i) {
      m.q.col(i) += ((1 + dt * drag) * m.mass[i]) * m.d.col(i);
      curvature += m.d.col(i).dot(m.q.col(i));
    }
    if (!(curvature > 0)) {
      if (k == 0) m.dv = m.z;
      break;
    }
    const double alpha = rho / curvature, last = rho;
    for (int i = 0; i < n; ++i) {
      m.dv.col(i) += alpha * m.d.col(i);
      m.r.col(i) -= alpha * m.q.col(i);
    }
    rho = precondition();
    for (int i = 0; i < n; ++i) m.d.col(i) = m.z.col(i) + (rho / last) * m.d.col(i);
  }

  m.v += m.dv;
  const double move = dt * largest(m.v, n);
  if (move > longest_move_) m.v *= longest_move_ / move;
  m.x += dt * m.v;
  return {};
}

}  // namespace vacuform
