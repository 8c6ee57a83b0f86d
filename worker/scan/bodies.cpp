#include "worker/scan/bodies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

constexpr double body_share = 0.4;       // of the largest diagonal
constexpr double least_compact = 0.35;   // shortest over longest side of the box
constexpr double least_filled = 0.3;     // of the box; an ellipsoid fills half of it
constexpr double least_enclosed = 0.1;   // of the box: less is a shell
constexpr double most_flat = 0.3;        // of the area; half a head that is cut flat has a third
constexpr double flat_face = 0.03;       // of the area in one direction: larger ones are flat faces
constexpr double least_rounded = 0.3;    // of the area neither along nor across an axis
constexpr double ball_deviation = 0.02;  // of the radius

// Rays from one point in 14 directions that meet the surface.
int hits_from(const Eigen::Vector3d& p, const RayCaster& body, double reach) {
  int hits = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Eigen::Vector3d d(0.013, -0.017, 0.011);  // off the axes, so as not to run along edges
      d[axis] += sign;
      hits += body.first_hit(p, d * reach).has_value();
    }
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    hits += body.first_hit(p, d * reach).has_value();
  }
  return hits;
}
constexpr int hits_inside = 12, hits_outside = 7;

// The share of its box that a body encloses, on a grid.
double filled_share(const Box& box, const RayCaster& body) {
  constexpr int n = 6;
  const Eigen::Vector3d size = box.size();
  const double reach = 2 * size.norm();
  int inside = 0;
  for (int i = 0; i < n * n * n; ++i) {
    const Eigen::Vector3d share((i % n + 0.5) / n, (i / n % n + 0.5) / n, (i / n / n + 0.5) / n);
    inside += hits_from(box.low + share.cwiseProduct(size), body, reach) >= hits_inside;
  }
  return static_cast<double>(inside) / (n * n * n);
}

// Whether a body has the rounded surface of a head, and not that of a stand, a box or a ball.
bool is_rounded(const TriangleMesh& body) {
  std::map<std::array<int, 3>, double> by_direction;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double total = 0;
  const auto centre_of = [&](const Triangle& t) -> Eigen::Vector3d {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int v : t) sum += body.vertices[v];
    return sum / 3;
  };
  for (const Triangle& t : body.triangles) {
    const Eigen::Vector3d a = area_vector(body, t);
    const double area = a.norm();
    if (!(area > 0)) continue;
    const Eigen::Vector3d n = a / area;
    by_direction[{static_cast<int>(std::lround(n.x() * 20)), static_cast<int>(std::lround(n.y() * 20)),
                  static_cast<int>(std::lround(n.z() * 20))}] += area;
    spread += area * n * n.transpose();
    middle += area * centre_of(t);
    total += area;
  }
  if (!(total > 0)) return false;
  double flat = 0;
  for (const auto& [direction, area] : by_direction)
    if (area > flat_face * total) flat += area;
  if (flat > most_flat * total) return false;

  const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  Eigen::Vector3d rounded = Eigen::Vector3d::Zero();
  middle /= total;
  double radius = 0, square = 0;
  for (const Triangle& t : body.triangles) {
    const Eigen::Vector3d a = area_vector(body, t);
    const double area = a.norm();
    if (!(area > 0)) continue;
    const Eigen::Vector3d along = (axes.transpose() * a / area).cwiseAbs();
    for (int k = 0; k < 3; ++k)
      if (along[k] > 0.1 && along[k] < 0.97) rounded[k] += area;
    const double r = (centre_of(t) - middle).norm();
    radius += area * r / total;
    square += area * r * r / total;
  }
  if (rounded.minCoeff() < least_rounded * total) return false;
  return std::sqrt(std::max(0.0, square - radius * radius)) > ball_deviation * radius;
}

}  // namespace

Place place_of(const TriangleMesh& piece, const RayCaster& body, double reach) {
  const std::size_t stride = std::max<std::size_t>(1, piece.vertices.size() / 64);
  Place place;
  for (std::size_t i = 0; i < piece.vertices.size(); i += stride) {
    const int hits = hits_from(piece.vertices[i], body, reach);
    ++place.samples;
    place.inside += hits >= hits_inside;
    place.outside += hits <= hits_outside;
  }
  return place;
}

std::vector<Body> find_bodies(std::span<const TriangleMesh> pieces) {
  std::vector<Body> bodies;
  std::vector<std::unique_ptr<RayCaster>> casters;
  double largest = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Box box = bounds(pieces[i]);
    const double diagonal = box.size().norm();
    if (i == 0) largest = diagonal;
    if (diagonal < body_share * largest) break;
    if (!(box.size().minCoeff() > 0)) continue;
    const bool apart = std::ranges::all_of(
        casters, [&](const auto& larger) { return place_of(pieces[i], *larger, 2 * largest).inside == 0; });
    if (!apart) continue;
    auto caster = std::make_unique<RayCaster>(pieces[i]);
    const double filled = filled_share(box, *caster);
    if (filled < least_enclosed) continue;
    casters.push_back(std::move(caster));
    const bool compact = box.size().minCoeff() >= least_compact * box.size().maxCoeff();
    bodies.push_back({static_cast<int>(i), compact && filled >= least_filled && is_rounded(pieces[i]),
                      box.centre(), box.size()});
  }
  if (bodies.empty()) return bodies;
  Eigen::Vector3d low = bodies.front().centre, high = low;
  for (const Body& body : bodies) low = low.cwiseMin(body.centre), high = high.cwiseMax(body.centre);
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::ranges::stable_sort(bodies, {}, [&](const Body& body) { return body.centre[axis]; });
  return bodies;
}

}  // namespace vacuform
