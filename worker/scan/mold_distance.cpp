#include "worker/scan/mold_distance.hpp"

#if VACUFORM_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/scan/embree_scene.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;

double squared_distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).squaredNorm();
  const double sum = va + vb + vc;
  if (!(sum > 0)) return std::min({ap.squaredNorm(), bp.squaredNorm(), cp.squaredNorm()});
  return (ap - vb / sum * ab - vc / sum * ac).squaredNorm();
}

struct Search {
  const TriangleMesh& mesh;
  Vector3d point;
  double best = std::numeric_limits<double>::infinity();  // squared
  double enough = 0;                                      // squared: nothing nearer is looked for
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  const auto& t = search.mesh.triangles[arguments->primID];
  const auto corner = [&](int k) -> const Vector3d& {
    return search.mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
  };
  const double squared = squared_distance(search.point, corner(0), corner(1), corner(2));
  if (!(squared < search.best)) return false;
  search.best = squared;
  // The tree holds floats: its boxes may be off by a little, so it is searched a little further.
  arguments->query->radius =
      squared < search.enough ? 0 : static_cast<float>(std::sqrt(squared) * 1.0001 + 1e-3);
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

}  // namespace

MoldDistance::MoldDistance(const TriangleMesh& mesh)
    : mesh_(mesh), scene_(std::make_shared<const EmbreeScene>(mesh)) {}
MoldDistance::MoldDistance(const TriangleMesh& mesh, const RayCaster& rays)
    : mesh_(mesh), scene_(rays.scene()) {}

double MoldDistance::operator()(const Vector3d& point) const {
  // Most points are near: a small sphere around them holds few triangles.
  for (const float radius : {1.0f, std::numeric_limits<float>::infinity()}) {
    Search search{.mesh = mesh_, .point = point};
    look(*scene_, search, radius);
    if (search.best <= radius * radius) return std::sqrt(search.best);
  }
  return std::numeric_limits<double>::infinity();
}

bool MoldDistance::within(const Vector3d& point, double distance_mm) const {
  Search search{.mesh = mesh_, .point = point, .enough = distance_mm * distance_mm};
  look(*scene_, search, static_cast<float>(distance_mm * 1.0001 + 1e-3));
  return search.best < search.enough;
}

}  // namespace vacuform
