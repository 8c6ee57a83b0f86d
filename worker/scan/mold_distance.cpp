#include "worker/scan/mold_distance.hpp"

#if VACUFORM_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "worker/scan/embree_scene.hpp"
#include "worker/surface/nearest_point.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;

// From p to the closest point of the triangle.
Vector3d way_to(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return -ap;
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return -bp;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return d1 / (d1 - d3) * ab - ap;
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return -cp;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return d2 / (d2 - d6) * ac - ap;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b) - bp;
  const double sum = va + vb + vc;
  if (!(sum > 0))
    return -std::min({ap, bp, cp},
                     [](const Vector3d& u, const Vector3d& v) { return u.squaredNorm() < v.squaredNorm(); });
  return vb / sum * ab + vc / sum * ac - ap;
}

// Weights of the corners at the point of the triangle that is closest to p.
Vector3d closest_weights(const Vector3d& p, const std::array<Vector3d, 3>& corners) {
  const Vector3d ab = corners[1] - corners[0], ac = corners[2] - corners[0], ap = p - corners[0];
  const double bb = ab.squaredNorm(), bc = ab.dot(ac), cc = ac.squaredNorm(), d = bb * cc - bc * bc;
  if (d > 0) {
    const double v = (cc * ab.dot(ap) - bc * ac.dot(ap)) / d, w = (bb * ac.dot(ap) - bc * ab.dot(ap)) / d;
    if (v >= 0 && w >= 0 && v + w <= 1) return {1 - v - w, v, w};
  }
  Vector3d best = Vector3d::UnitX();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const Vector3d &a = corners[k], &b = corners[next];
    const double along = nearest_on_edge(p, a, b), squared = (p - a - along * (b - a)).squaredNorm();
    if (!(squared < least)) continue;
    least = squared;
    best = Vector3d::Zero();
    best[k] = 1 - along;
    best[next] = along;
  }
  return best;
}

struct Search {
  const TriangleMesh& mesh;
  Vector3d point;
  double best = std::numeric_limits<double>::infinity();  // squared
  Vector3d way = Vector3d::Zero();                        // to the best
  int triangle = -1;                                      // of the best
  double enough = 0;                                      // squared: the search ends below it

  // Whether the triangle is closer than the best so far, and so becomes the best. Of equally close ones, the first of the mesh
  // is the best: processors look at them in different orders.
  bool offer(int candidate) {
    const Triangle& t = mesh.triangles[candidate];
    const auto corner = [&](std::size_t k) -> const Vector3d& { return mesh.vertices[t[k]]; };
    const Vector3d to_it = way_to(point, corner(0), corner(1), corner(2));
    const double squared = to_it.squaredNorm();
    if (!(squared < best || (squared == best && candidate < triangle))) return false;
    best = squared;
    way = to_it;
    triangle = candidate;
    return true;
  }
  // How far to search for better ones. The tree holds floats: its boxes may be off by a little, so it is searched a
  // little further.
  float radius() const { return static_cast<float>(std::sqrt(best) * 1.0001 + 1e-3); }
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  if (!search.offer(static_cast<int>(arguments->primID))) return false;
  arguments->query->radius = search.best < search.enough ? 0 : search.radius();
  return true;
}

// Looks at the triangles of the mesh within a radius of the point.
void look(const EmbreeScene& scene, Search& search, float radius) {
  RTCPointQuery query{};
  query.x = static_cast<float>(search.point.x() - scene.centre.x());
  query.y = static_cast<float>(search.point.y() - scene.centre.y());
  query.z = static_cast<float>(search.point.z() - scene.centre.z());
  query.radius = radius;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene.scene, &query, &context, visit, &search);
}

Search search_all(const TriangleMesh& mesh, const EmbreeScene& scene, const Vector3d& point) {
  Search search{.mesh = mesh, .point = point};
  // Most points are near: a small sphere around them holds few triangles.
  constexpr float near_mm = 1;
  look(scene, search, near_mm);
  if (search.best > near_mm * near_mm) look(scene, search, std::numeric_limits<float>::infinity());
  return search;
}

}  // namespace

MoldDistance::MoldDistance(const TriangleMesh& mesh)
    : mesh_(mesh), scene_(std::make_shared<const EmbreeScene>(mesh, RayTree::tight)) {}
MoldDistance::MoldDistance(const TriangleMesh& mesh, const RayCaster& rays)
    : mesh_(mesh), scene_(rays.scene()) {}

double MoldDistance::operator()(const Vector3d& point) const {
  return std::sqrt(search_all(mesh_, *scene_, point).best);
}

double MoldDistance::operator()(const Vector3d& point, int& triangle) const {
  if (triangle < 0) {
    const Search search = search_all(mesh_, *scene_, point);
    triangle = search.triangle;
    return std::sqrt(search.best);
  }
  Search search{.mesh = mesh_, .point = point};
  search.offer(triangle);
  look(*scene_, search, search.radius());
  triangle = search.triangle;
  return std::sqrt(search.best);
}

Vector3d MoldDistance::nearest(const Vector3d& point) const {
  return point + search_all(mesh_, *scene_, point).way;
}

bool MoldDistance::within(const Vector3d& point, double distance_mm) const {
  Search search{.mesh = mesh_, .point = point, .enough = distance_mm * distance_mm};
  look(*scene_, search, static_cast<float>(distance_mm * 1.0001 + 1e-3));
  return search.best < search.enough;
}

std::optional<MoldDistance::Nearest> MoldDistance::nearest(const Vector3d& point, double reach_mm,
                                                           int guess) const {
  Search search{.mesh = mesh_, .point = point};
  if (guess >= 0) search.offer(guess);
  look(*scene_, search, std::min(search.radius(), static_cast<float>(reach_mm * 1.0001 + 1e-3)));
  const double distance = std::sqrt(search.best);
  if (search.triangle < 0 || !(distance <= reach_mm)) return std::nullopt;
  const Triangle& t = mesh_.triangles[search.triangle];
  const auto corner = [&](std::size_t k) { return mesh_.vertices[t[k]]; };
  return Nearest{search.triangle, closest_weights(point, {corner(0), corner(1), corner(2)}), distance};
}

}  // namespace vacuform
