#include "worker/forming/contact.hpp"

#include <Eigen/Geometry>

namespace vacuform {

namespace {
// A ray starts this much early, mm: a point that rests against the mold within rounding must still meet it.
constexpr double back_off = 0.02;
}  // namespace

std::optional<Obstacles::Touch> Obstacles::first_touch(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const Eigen::Vector3d way = to - from;
  const double length = way.norm();
  if (length == 0) return std::nullopt;
  std::optional<Touch> touch;
  if (to.z() < 0 && from.z() >= 0) {
    const double t = from.z() / (from.z() - to.z());
    touch = Touch{t, from + t * way, Contact::platform};
    touch->place.z() = 0;
  }

  const double early = back_off / length;
  const Eigen::Vector3d origin = from - early * way, direction = (1 + early) * way;
  if (const auto hit = rays_.first_hit(origin, direction)) {
    const Triangle& f = mold_.triangles[hit->triangle];
    const Eigen::Vector3d a = mold_.vertices[f[0]], b = mold_.vertices[f[1]], c = mold_.vertices[f[2]];
    const bool entering = (b - a).cross(c - a).dot(way) < 0;
    const double t = std::max(0.0, hit->t * (1 + early) - early);
    if (entering && (!touch || t < touch->t))
      touch = Touch{t, (1 - hit->u - hit->v) * a + hit->u * b + hit->v * c, Contact::mold};
  }
  return touch;
}

}  // namespace vacuform
