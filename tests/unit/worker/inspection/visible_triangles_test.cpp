#include "worker/inspection/visible_triangles.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/scan/ray_caster.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;
using Samples = std::vector<VisibleTriangles::Sample>;

// A wavy square of 2 n^2 triangles, 100 mm wide, with a roof over a part of it.
TriangleMesh waves(int n) {
  TriangleMesh mesh;
  for (const double height : {0.0, 30.0})
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x)
        mesh.vertices.emplace_back((height > 0 ? 30.0 : 100.0) * x / n - 50, 100.0 * y / n - 50,
                                   height + 6 * std::sin(7.0 * x / n) * std::cos(9.0 * y / n));
  for (const int first : {0, (n + 1) * (n + 1)})
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const int a = first + y * (n + 1) + x, c = a + n + 1;
        mesh.triangles.push_back({a, a + 1, c});
        mesh.triangles.push_back({a + 1, c + 1, c});
      }
  return mesh;
}

// From the front and above, at the middle of a picture of 90 x 70 pixels.
Camera slanting(double distance) {
  Camera camera;
  camera.back = Vector3d(0, -0.6, 0.8);
  camera.up = Vector3d(0, 0.8, 0.6);
  camera.eye = distance * camera.back;
  camera.pixel = 1.3 / distance;
  camera.middle_x = 45, camera.middle_y = 35;
  return camera;
}

Samples samples_of(const TriangleMesh& mesh, const Camera& camera) {
  Samples samples;
  VisibleTriangles(mesh, camera, 90).see(0, 70, samples);
  return samples;
}

Vector3d aim_of(const Camera& camera, std::size_t sample) {
  return camera.aim((static_cast<double>(sample % 180) + 0.5) / 2,
                    (static_cast<double>(sample / 180) + 0.5) / 2);
}

TEST(VisibleTriangles, AreThoseThatRaysMeetFirst) {
  const TriangleMesh mesh = waves(40);
  const RayCaster rays(mesh);
  const Camera camera = slanting(300);
  const Samples samples = samples_of(mesh, camera);
  int hits = 0, others = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vector3d aim = aim_of(camera, i);
    const auto hit = rays.first_hit(camera.eye, 2000 * aim);
    others += hit.has_value() != (samples[i].triangle >= 0);  // at the very edge
    if (!hit || samples[i].triangle < 0) continue;
    ++hits;
    others += std::abs(2000 * hit->t * samples[i].nearness - 1) > 1e-4;
    // The place by the weights is the place by the distance.
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(samples[i].triangle)];
    const double u = samples[i].u, v = samples[i].v;
    const auto corner = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    EXPECT_LT(
        ((1 - u - v) * corner(0) + u * corner(1) + v * corner(2) - (camera.eye + aim / samples[i].nearness))
            .norm(),
        1e-4);
  }
  EXPECT_GT(hits, 8000);
  EXPECT_LE(others, 3);
}

TEST(VisibleTriangles, LeaveNoGapBetweenThem) {
  // Flat, its edges exactly along rows, columns and diagonals of samples.
  TriangleMesh mesh = waves(60);
  for (Vector3d& p : mesh.vertices) p.z() = 0;
  Camera camera;
  camera.eye = {0, 0, 200};
  camera.pixel = 1.0 / 200;
  camera.middle_x = 45.25, camera.middle_y = 35.25;
  const Samples samples = samples_of(mesh, camera);
  for (std::size_t i = 0; i < samples.size(); ++i)
    EXPECT_GE(samples[i].triangle, 0) << i / 180 << " " << i % 180;
}

TEST(VisibleTriangles, MayReachBehindTheEye) {
  // A floor 10 mm below the eye that looks along it.
  const TriangleMesh floor{{{-1000, -1000, -10}, {1000, -1000, -10}, {0, 5000, -10}}, {{0, 1, 2}}};
  Camera camera;
  camera.back = {0, -1, 0};
  camera.up = {0, 0, 1};
  camera.pixel = 0.01;
  camera.middle_x = 45, camera.middle_y = 35;
  const Samples samples = samples_of(floor, camera);
  for (std::size_t row = 0; row < 140; ++row) {
    const VisibleTriangles::Sample& sample = samples[180 * row + 90];
    const double below = aim_of(camera, 180 * row + 90).z();
    if (below > -0.002) {  // beyond its end
      EXPECT_EQ(sample.triangle, -1) << row;
    } else {
      EXPECT_EQ(sample.triangle, 0) << row;
      EXPECT_NEAR(sample.nearness, -below / 10, 1e-12);
    }
  }
}

TEST(VisibleTriangles, DoNotDependOnTheRowsAskedFor) {
  const TriangleMesh mesh = waves(40);
  const Camera camera = slanting(300);
  const Samples whole = samples_of(mesh, camera);
  const VisibleTriangles visible(mesh, camera, 90);
  Samples part;
  for (int row = 0; row < 70; row += 7) {
    visible.see(row, row + 7, part);
    ASSERT_EQ(part.size(), 7u * 360);
    for (std::size_t i = 0; i < part.size(); ++i) {
      const VisibleTriangles::Sample& same = whole[static_cast<std::size_t>(row) * 360 + i];
      EXPECT_EQ(part[i].triangle, same.triangle);
      EXPECT_EQ(part[i].nearness, same.nearness);
      EXPECT_EQ(part[i].u, same.u);
    }
  }
}

}  // namespace
}  // namespace vacuform
