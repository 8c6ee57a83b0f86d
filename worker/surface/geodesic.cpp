#include "worker/surface/geodesic.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double least_weight = 1e-9;    // of a vertex, so that no path meets one
constexpr int most_crossings = 100'000;  // of one advance: a path that circles without end stops there

// The direction in the plane of triangle t nearest to a given one; zero where that is normal to it.
Vector3d in_plane(const InkedSurface& surface, int t, const Vector3d& direction) {
  const Vector3d d = direction - direction.dot(surface.normal(t)) * surface.normal(t);
  return d.squaredNorm() > 0 ? Vector3d(d.normalized()) : Vector3d(Vector3d::Zero());
}

// The directions of a straight line in space at its two ends.
Connection straight(const InkedSurface& surface, const SheetPoint& a, const SheetPoint& b) {
  const Vector3d way = surface.place(b) - surface.place(a);
  return {way.norm(), in_plane(surface, a.triangle, way), in_plane(surface, b.triangle, way), false};
}

// Newton steps in polar coordinates about a, with the derivatives of the plane.
Connection shoot(const InkedSurface& surface, const SheetPoint& a, const SheetPoint& b, Connection guess) {
  constexpr int most_steps = 25;
  const Vector3d goal = surface.place(b);
  Connection best = guess;
  double direction = 0, mm = guess.mm, least = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_steps; ++step) {
    const Vector3d leaving = turned(surface, a.triangle, guess.leaving, direction);
    GeodesicWalk walk(surface, a, leaving);
    const double walked = walk.advance(mm);
    const int t = walk.at().triangle;
    const Vector3d off = goal - surface.place(walk.at());
    const double ahead = off.dot(walk.along()), aside = off.dot(surface.normal(t).cross(walk.along()));
    if (off.norm() < least) {
      least = off.norm();
      best.leaving = leaving;
      best.mm = walked + ahead + aside * aside / (2 * std::max(walked, 1e-9));
      // The plane of the last triangle is as accurate as that of the triangle of b, which is at most a step away.
      best.arriving = in_plane(surface, b.triangle, walk.along());
    }
    if (off.norm() < 1e-7 || walk.ended()) break;
    direction += std::clamp(aside / std::max(walked, 1e-3), -0.3, 0.3);
    mm = std::max(walked + ahead, 0.3 * guess.mm);
  }
  best.found = least <= std::max(0.01 * best.mm, 1e-3);
  return best;
}

}  // namespace

GeodesicWalk::GeodesicWalk(const InkedSurface& surface, const SheetPoint& start, const Vector3d& along)
    : surface_(&surface), at_(start), along_(along) {
  at_.weights = at_.weights.cwiseMax(least_weight);
  at_.weights /= at_.weights.sum();
  along_ -= along_.dot(surface.normal(start.triangle)) * surface.normal(start.triangle);
  along_.normalize();
}

double GeodesicWalk::advance(double mm) {
  double walked = 0;
  for (int crossings = 0; !ended_ && walked < mm; ++crossings) {
    const int t = at_.triangle;
    int out = -1;
    double way = std::numeric_limits<double>::infinity();
    Vector3d rate;
    for (int k = 0; k < 3; ++k) {
      rate[k] = surface_->gradient(t, k).dot(along_);
      if (k == entered_ || rate[k] >= 0) continue;
      if (const double s = at_.weights[k] / -rate[k]; s < way) way = s, out = k;
    }
    if (walked + way >= mm && out >= 0) {
      at_.weights = (at_.weights + (mm - walked) * rate).cwiseMax(0);
      at_.weights /= at_.weights.sum();
      entered_ = -1;
      return mm;
    }
    if (out < 0 || crossings == most_crossings) {  // a triangle without area
      ended_ = true;
      break;
    }
    at_.weights += way * rate;
    walked += way;
    cross(out);
  }
  return walked;
}

void GeodesicWalk::cross(int corner) {
  const int t = at_.triangle, n = surface_->across(t, corner);
  at_.weights[corner] = 0;
  if (n < 0) {
    ended_ = true;
    return;
  }
  const Triangle &from = surface_->triangles()[t], &to = surface_->triangles()[n];
  const auto at = [](const Triangle& triangle, int k) { return triangle[k]; };
  Vector3d weights = Vector3d::Zero();
  int entry = 0;
  for (int k = 0; k < 3; ++k) {
    const int v = at(to, k);
    if (v == at(from, (corner + 1) % 3))
      weights[k] = std::max(at_.weights[(corner + 1) % 3], least_weight);
    else if (v == at(from, (corner + 2) % 3))
      weights[k] = std::max(at_.weights[(corner + 2) % 3], least_weight);
    else
      entry = k;
  }
  const auto& place = surface_->inked();
  const Vector3d edge = (place[at(from, (corner + 2) % 3)] - place[at(from, (corner + 1) % 3)]).normalized();
  const Vector3d outward = -surface_->gradient(t, corner).normalized(),
                 inward = surface_->gradient(n, entry).normalized();
  along_ = (along_.dot(edge) * edge + along_.dot(outward) * inward).normalized();
  at_ = {n, weights / weights.sum()};
  entered_ = entry;
}

Vector3d turned(const InkedSurface& surface, int t, const Vector3d& direction, double radians) {
  return std::cos(radians) * direction + std::sin(radians) * surface.normal(t).cross(direction);
}

double angle_between(const InkedSurface& surface, int t, const Vector3d& from, const Vector3d& to) {
  return std::atan2(surface.normal(t).dot(from.cross(to)), from.dot(to));
}

Connection connect(const InkedSurface& surface, const SheetPoint& a, const SheetPoint& b) {
  const Connection line = straight(surface, a, b);
  if (line.mm < 1e-9) return {0, line.leaving, line.arriving, true};
  Connection best = line;
  for (const double aside : {0.0, 0.3, -0.3}) {
    Connection guess = line;
    guess.leaving = turned(surface, a.triangle, line.leaving, aside);
    const Connection way = shoot(surface, a, b, guess);
    if (way.found && (!best.found || way.mm < best.mm - 1e-6)) best = way;
  }
  return best;
}

}  // namespace vacuform
