#include "worker/scan/ray_caster.hpp"

#if VACUFORM_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <stdexcept>

namespace vacuform {

struct RayCaster::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();

  ~Scene() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

RayCaster::RayCaster(const TriangleMesh& mesh) : scene_(std::make_unique<Scene>()) {
  // One thread builds: the tree, and with it the order of equal hits, is then the same on every machine.
  scene_->device = rtcNewDevice("threads=1,set_affinity=0");
  if (!scene_->device) throw std::runtime_error("Embree cannot start");
  scene_->scene = rtcNewScene(scene_->device);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_->scene, RTC_BUILD_QUALITY_MEDIUM);

  if (!mesh.triangles.empty()) {
    Eigen::Vector3d low = mesh.vertices.front(), high = low;
    for (const auto& p : mesh.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
    scene_->centre = (low + high) / 2;

    RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
    if (!points || !indices) throw std::bad_alloc();
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      for (int k = 0; k < 3; ++k)
        points[3 * i + k] = static_cast<float>(mesh.vertices[i][k] - scene_->centre[k]);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k) indices[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][k]);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_->scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene_->scene);
  if (rtcGetDeviceError(scene_->device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree cannot build its scene");
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

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
  return Hit{query.ray.tfar, static_cast<int>(query.hit.primID), query.hit.u, query.hit.v};
}

}  // namespace vacuform
