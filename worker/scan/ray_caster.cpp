#include "worker/scan/ray_caster.hpp"

#if VACUFORM_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <Eigen/Geometry>
#include <algorithm>

#include "worker/scan/embree_scene.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

// The point of the triangle where the ray meets it. Embree divides by approximate reciprocals, which differ between processors, so
// its own figures count only for a triangle that is seen exactly edge-on. The point never leaves the triangle: one that is seen
// almost edge-on has no other bound for its distance.
RayCaster::Hit exact_hit(const EmbreeScene& scene, const RayCaster::Hit& found, const Vector3d& origin,
                         const Vector3d& direction) {
  const auto corner = [&](int k) {
    return Eigen::Map<const Eigen::Vector3f>(scene.points + 3 * scene.corners[3 * found.triangle + k])
        .cast<double>()
        .eval();
  };
  const Vector3d a = corner(0), ab = corner(1) - a, ac = corner(2) - a, normal = ab.cross(ac);
  double u = found.u, v = found.v;
  if (const double along = normal.dot(direction); along != 0) {
    const Vector3d at = direction * (normal.dot(a - origin) / along) - (a - origin);
    u = at.cross(ac).dot(normal) / normal.squaredNorm();
    v = ab.cross(at).dot(normal) / normal.squaredNorm();
  }
  u = std::clamp(u, 0.0, 1.0);
  v = std::clamp(v, 0.0, 1 - u);
  const double t = (a + u * ab + v * ac - origin).dot(direction) / direction.squaredNorm();
  return {std::clamp(t, 0.0, 1.0), found.triangle, u, v};
}

}  // namespace

RayCaster::RayCaster(const TriangleMesh& mesh, RayTree tree)
    : scene_(std::make_shared<const EmbreeScene>(mesh, tree)) {}

std::optional<RayCaster::Hit> RayCaster::first_hit(const Eigen::Vector3d& origin,
                                                   const Eigen::Vector3d& direction) const {
  const Eigen::Vector3f o = (origin - scene_->centre).cast<float>();
  const Eigen::Vector3f d = direction.cast<float>();
  RTCRayHit query;
  query.ray = {o.x(), o.y(), o.z(), 0.0f, d.x(), d.y(), d.z(), 0.0f, 1.0f, ~0u, 0, 0};
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
#if VACUFORM_EMBREE >= 4
  rtcIntersect1(scene_->scene, &query, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_->scene, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return exact_hit(*scene_, {query.ray.tfar, static_cast<int>(query.hit.primID), query.hit.u, query.hit.v},
                   o.cast<double>(), d.cast<double>());
}

bool lies_below(const TriangleMesh& mesh, const RayCaster& rays, const Eigen::Vector3d& point,
                double height) {
  const auto hit = rays.first_hit(point, {0, 0, height});
  return hit && area_vector(mesh, mesh.triangles[hit->triangle]).z() > 0;
}

}  // namespace vacuform
