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

// Where a ray meets a triangle of the scene. Embree divides by approximate reciprocals, which differ between processors.
RayCaster::Hit exact_hit(const EmbreeScene& scene, int triangle, const Vector3d& origin,
                         const Vector3d& direction) {
  const auto corner = [&](int k) {
    return Eigen::Map<const Eigen::Vector3f>(scene.points + 3 * scene.corners[3 * triangle + k])
        .cast<double>()
        .eval();
  };
  const Vector3d a = corner(0), ab = corner(1) - a, ac = corner(2) - a, normal = ab.cross(ac);
  const double along = normal.dot(direction);
  const double t = std::clamp(normal.dot(a - origin) / along, 0.0, 1.0);
  const Vector3d at = origin + t * direction - a;
  return {t, triangle, at.cross(ac).dot(normal) / normal.squaredNorm(),
          ab.cross(at).dot(normal) / normal.squaredNorm()};
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
  return exact_hit(*scene_, static_cast<int>(query.hit.primID), o.cast<double>(), d.cast<double>());
}

bool lies_below(const TriangleMesh& mesh, const RayCaster& rays, const Eigen::Vector3d& point,
                double height) {
  const auto hit = rays.first_hit(point, {0, 0, height});
  return hit && area_vector(mesh, mesh.triangles[hit->triangle]).z() > 0;
}

}  // namespace vacuform
