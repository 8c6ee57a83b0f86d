#include "worker/scan/embree_scene.hpp"

#if VACUFORM_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <tbb/global_control.h>

#include <new>
#include <stdexcept>

#include "worker/scan/ray_caster.hpp"

namespace vacuform {

namespace {

void fill(EmbreeScene& to, const TriangleMesh& mesh, RayTree tree) {
  // Only one thread builds the tree, so that the tree, and with it the order of equal hits, is the same on every
  // machine. (Embree's own option, threads=1, would keep every other loop of the process on one thread while the scene
  // exists.)
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  to.device = rtcNewDevice("set_affinity=0");
  if (!to.device) throw std::runtime_error("Embree cannot start");
  to.scene = rtcNewScene(to.device);
  const bool quick = tree == RayTree::quick;
  rtcSetSceneFlags(to.scene, quick ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_ROBUST);
  const RTCBuildQuality quality = quick ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM;
  rtcSetSceneBuildQuality(to.scene, quality);

  if (!mesh.triangles.empty()) {
    Eigen::Vector3d low = mesh.vertices.front(), high = low;
    for (const auto& p : mesh.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
    to.centre = (low + high) / 2;

    RTCGeometry geometry = rtcNewGeometry(to.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
    if (!points || !indices) throw std::bad_alloc();
    to.points = points;
    to.corners = indices;
    for (const auto& p : mesh.vertices)
      for (int k = 0; k < 3; ++k) *points++ = static_cast<float>(p[k] - to.centre[k]);
    for (const Triangle& t : mesh.triangles)
      for (const int v : t) *indices++ = static_cast<unsigned>(v);
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(to.scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(to.scene);
  if (rtcGetDeviceError(to.device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree cannot build its scene");
}

void release(EmbreeScene& scene) {
  if (scene.scene) rtcReleaseScene(scene.scene);
  if (scene.device) rtcReleaseDevice(scene.device);
}

}  // namespace

EmbreeScene::EmbreeScene(const TriangleMesh& mesh, RayTree tree) {
  try {
    fill(*this, mesh, tree);
  } catch (...) {
    release(*this);
    throw;
  }
}

EmbreeScene::~EmbreeScene() { release(*this); }

}  // namespace vacuform
