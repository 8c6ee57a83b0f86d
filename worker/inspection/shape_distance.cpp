#include "worker/inspection/shape_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "worker/numerics/dense.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/pattern/even_points.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Line = std::vector<Vector2d>;
using Complex = std::complex<double>;
constexpr int samples = 180, rounds = 10;

struct Nearest {
  Vector2d point, along;  // `along` the line there
};
Nearest nearest(const Line& line, const Vector2d& p) {
  Nearest best{line.front(), {1, 0}};
  double least = INFINITY;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector2d& a = line[i];
    const Vector2d along = line[(i + 1) % line.size()] - a;
    const double square = along.squaredNorm();
    // No point of the piece is nearer than its start less its length.
    if (const double off = (p - a).squaredNorm(); off > 4 * std::max(least, square)) continue;
    const double f = square > 0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0;
    const Vector2d q = a + f * along;
    if (const double d = (p - q).squaredNorm(); d < least) least = d, best = {q, along};
  }
  return best;
}

double farthest(const Line& from, const Line& to) {
  double most = 0;
  for (const Vector2d& p : from) most = std::max(most, (nearest(to, p).point - p).norm());
  return most;
}

double squares(const Line& from, const Line& to) {
  double sum = 0;
  for (const Vector2d& p : from) sum += (nearest(to, p).point - p).squaredNorm();
  return sum;
}

Vector2d middle(const Line& points) {
  Vector2d sum(0, 0);
  for (const Vector2d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// The sum of conj(from) * to about their middles: its angle is the best rotation, its size the quality of the fit.
Complex fit(const Line& from, const Line& to, std::size_t shift) {
  const Vector2d a = middle(from), b = middle(to);
  Complex sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vector2d p = from[i] - a, q = to[(i + shift) % to.size()] - b;
    sum += Complex(p.x(), -p.y()) * Complex(q.x(), q.y());
  }
  return sum;
}

// Rotates and moves points onto their counterparts.
struct Motion {
  Complex turn;
  Vector2d from, to;
  Motion(const Complex& best, const Vector2d& a, const Vector2d& b)
      : turn(std::abs(best) > 0 ? best / std::abs(best) : Complex(1)), from(a), to(b) {}
  void move(Line& line) const {
    for (Vector2d& p : line) {
      const Complex z = turn * Complex(p.x() - from.x(), p.y() - from.y());
      p = to + Vector2d(z.real(), z.imag());
    }
  }
};

// Lambert's map: a geodesic radius r becomes 2 R sin(r / 2 R) on a sphere of radius R.
Line lambert(Line polar, double curvature) {
  for (Vector2d& p : polar) {
    const double x = std::sqrt(std::abs(curvature)) * p.norm() / 2;
    if (x > 1e-9) p *= (curvature > 0 ? std::sin(x) : std::sinh(x)) / x;
  }
  return polar;
}

// One Gauss-Newton step for the distances to the line, each along its own direction (Chen and Medioni 1992). For a
// circle every rotation is equally good: a small weight prevents it from turning.
Motion closer(const Line& points, const Line& line) {
  const Vector2d centre = middle(points);
  double radius = 0;
  for (const Vector2d& p : points) radius += (p - centre).norm() / static_cast<double>(points.size());
  Eigen::Matrix3d normal = Eigen::Vector3d(1e-4 * static_cast<double>(points.size()), 0, 0).asDiagonal();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Vector2d& p : points) {
    const Nearest on = nearest(line, p);
    const Vector2d off = p - on.point, across = Vector2d(-on.along.y(), on.along.x()).normalized();
    const double distance = off.norm();
    const Vector2d n = distance > 1e-9 ? Vector2d(off / distance) : across, arm = (p - centre) / radius;
    const Eigen::Vector3d row(cross(arm, n), n.x(), n.y());
    normal += row * row.transpose();
    right -= distance * row;
  }
  const Eigen::Vector3d step = shortest_least_squares(normal, right);
  return Motion(std::polar(1.0, step[0] / radius), centre, centre + step.tail<2>());
}

}  // namespace

ShapeDistance shape_distance(const Line& made, const Line& drawn) {
  if (made.size() < 3 || drawn.size() < 3) return {INFINITY, INFINITY};
  Line moved = made, few = even_points(made, samples);
  const Line wanted = even_points(drawn, samples);
  // The point of the drawn line at which the other one begins.
  std::size_t best = 0;
  Complex best_fit = 0;
  for (std::size_t shift = 0; shift < wanted.size(); ++shift)
    if (const Complex f = fit(few, wanted, shift); std::abs(f) > std::abs(best_fit) * (1 + 1e-9))
      best = shift, best_fit = f;
  const auto move = [&](const Motion& motion) { motion.move(few), motion.move(moved); };
  move(Motion(fit(few, wanted, best), middle(few), middle(wanted)));
  // If a line is far from the drawn one, steps may lead away from it: the best of them is used.
  Line nearest_few = few, nearest_moved = moved;
  double least = squares(few, drawn);
  for (int round = 0; round < rounds; ++round) {
    move(closer(few, drawn));
    if (const double now = squares(few, drawn); now < least)
      least = now, nearest_few = few, nearest_moved = moved;
  }
  few.swap(nearest_few), moved.swap(nearest_moved);
  ShapeDistance out;
  for (const Vector2d& p : few) out.mean_mm += (nearest(drawn, p).point - p).norm() / samples;
  out.largest_mm = std::max(farthest(moved, drawn), farthest(drawn, moved));
  return out;
}

Line true_to_area(Line polar, double area_mm2) {
  // A circle of radius r has the area pi r^2 (1 - K r^2 / 12). Each step is what a circle of that area would need.
  double curvature = 0;
  const double plane = lobes_area(polar);
  if (!(plane > 0) || !(area_mm2 > 0)) return polar;
  for (int round = 0; round < 20; ++round) {
    const double excess = lobes_area(lambert(polar, curvature)) / area_mm2 - 1;
    if (std::abs(excess) < 1e-9) break;
    curvature += 12 * M_PI / plane * excess;
  }
  // No loop reaches farther than a quarter of the way around such a sphere.
  double reach = 0;
  for (const Vector2d& p : polar) reach = std::max(reach, p.norm());
  if (!std::isfinite(curvature) || std::sqrt(std::abs(curvature)) * reach > M_PI / 2) return polar;
  return lambert(std::move(polar), curvature);
}

}  // namespace vacuform
