// What a ray meets, whatever the angle: a point of the triangle that it names, on the ray.
#include "worker/scan/ray_caster.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "tests/unit/fixtures/shapes.hpp"

namespace vacuform::ray_caster_test {
namespace {

using Eigen::Vector3d;

// Rays along the walls of a prism that stands off the centre and is turned: steep, nearly in a wall, and exactly in one.
TEST(RayCaster, HitsAPointOfTheTriangleOnTheRay) {
  const TriangleMesh mesh = frustum(34, 34, 24, 5, {3.3, -1.7}, 0.3).mesh;
  const RayCaster rays(mesh);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(-1, 1);
  int hits = 0;
  for (int round = 0; round < 60'000; ++round) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(round) % mesh.triangles.size()];
    const Vector3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    const Vector3d normal = (b - a).cross(c - a).normalized();
    const double slant = std::array{0.0, 1e-7, 1e-5, 1e-3, 0.3}[static_cast<std::size_t>(round) % 5];
    const Vector3d in_plane = (part(random) * (b - a) + part(random) * (c - a)).normalized();
    const Vector3d way = 25 * (in_plane - slant * normal).normalized(), at = (a + b + c) / 3;
    const Vector3d from = at - (0.5 + 0.4 * part(random)) * way;
    const auto hit = rays.first_hit(from, way);
    if (!hit) continue;
    ++hits;
    ASSERT_TRUE(hit->t >= 0 && hit->t <= 1) << hit->t << " in round " << round;
    ASSERT_TRUE(hit->u >= 0 && hit->v >= 0 && hit->u + hit->v <= 1 + 1e-12) << hit->u << " " << hit->v;
    const Triangle& of = mesh.triangles[hit->triangle];
    const Vector3d place = (1 - hit->u - hit->v) * mesh.vertices[of[0]] + hit->u * mesh.vertices[of[1]] +
                           hit->v * mesh.vertices[of[2]];
    // Of the two triangles of a wall, a ray in its plane may be said to meet the one beside it.
    if (slant >= 1e-5) {
      ASSERT_LT((place - from - hit->t * way).norm(), 1e-3) << "round " << round << ", slant " << slant;
    }
  }
  EXPECT_GT(hits, 20'000);
}

TEST(RayCaster, SaysHowFarAPlaneIsToTheLastDigitsOfAFloat) {
  TriangleMesh mesh;
  mesh.vertices = {{-50, -40, 7}, {60, -45, 7}, {5, 70, 7}};
  mesh.triangles = {{0, 1, 2}};
  for (const double z : {7.25, 9.0, 31.5}) {
    const auto hit = RayCaster(mesh).first_hit({3, 1, z}, {0, 0, -40});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(40 * hit->t, z - 7, 1e-12);
  }
}

}  // namespace
}  // namespace vacuform::ray_caster_test
