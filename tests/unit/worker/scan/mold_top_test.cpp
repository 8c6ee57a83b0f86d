// The top of a mold: the middle of its highest part, whatever the triangles and the turn.
#include "worker/scan/mold_top.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/plateaus.hpp"
#include "tests/unit/worker/scan/scan_shapes.hpp"

namespace vacuform::mold_top_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(MoldTop, IsTheMiddleOfTheHighestPartAtEveryAngle) {
  for (const plateaus::Solid& solid : plateaus::solids())
    for (double yaw = 0; yaw <= 90; yaw += 5) {
      plateaus::Solid at = plateaus::turned(solid, yaw);
      for (Vector3d& p : at.mesh.vertices) p = p.cast<float>().cast<double>();
      EXPECT_LT((top_of(at.mesh) - at.top).norm(), 0.01) << at.name;
    }
}

// From the file to the mold, which is centred by its outline and not by its top.
TEST(MoldTop, FollowsTheScanOntoThePlatform) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.trim_mm = 0;
  double yaw = 5;
  for (const plateaus::Solid& solid : plateaus::solids()) {
    const plateaus::Solid at = plateaus::turned(solid, yaw);
    const auto mold = make_mold(shapes::stl(at.mesh), "solid.stl", settings, Context());
    ASSERT_TRUE(mold) << at.name << ": " << mold.error().text();
    EXPECT_LT((mold->top - mold->placing(at.top)).norm(), 0.01) << at.name;
    EXPECT_EQ(mold->top.z(), bounds(mold->mesh).high.z());
    yaw = yaw < 80 ? yaw + 10 : yaw - 75;
  }
}

// On an ellipsoid the apex is known. Its highest vertex lies up to 2.4 mm beside it.
TEST(MoldTop, IsNearTheApexOfATiltedHeadOfCoarseTriangles) {
  const Vector3d radii(72, 95, 88);
  for (const int rings : {40, 60, 97})
    for (const double tilt : {0.0, 3.0, 11.0, 25.0}) {
      TriangleMesh mesh = shapes::sphere(1, rings);
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(tilt * std::numbers::pi / 180, Vector3d(0.8, 0.6, 0)).toRotationMatrix();
      for (Vector3d& p : mesh.vertices) p = turn * p.cwiseProduct(radii);
      const Vector3d up = turn.transpose() * Vector3d::UnitZ();
      const Vector3d apex =
          turn * (radii.cwiseProduct(radii).cwiseProduct(up) / radii.cwiseProduct(up).norm());
      const double facet = std::numbers::pi * 95 / rings;
      EXPECT_LT((top_of(mesh) - apex).head<2>().norm(), 0.55 * facet) << rings << " rings, " << tilt;
    }
}

// Tilted by less than the section is deep, a face keeps its middle; a bump lower than that does not attract the top.
TEST(MoldTop, DoesNotJumpWhereAFaceIsUnevenByRounding) {
  plateaus::Solid block = plateaus::block({80, 60, 30}, true);
  for (Vector3d& p : block.mesh.vertices)
    if (p.z() > 0) p.z() += 1e-5 * p.x() + 5e-6 * p.y();
  EXPECT_LT((top_of(block.mesh) - Vector3d(0, 0, 30)).head<2>().norm(), 0.01);
  block.mesh.vertices[5].z() += 0.001;
  EXPECT_LT((top_of(block.mesh) - Vector3d(0, 0, 30)).head<2>().norm(), 0.01);
}

// A new skin around a block is uneven by 0.008 mm.
TEST(MoldTop, DoesNotJumpWhereAClearanceMadeANewSkin) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  settings.units = Unit::mm;
  settings.trim_mm = 0;
  settings.clearance_mm = 1;
  const plateaus::Solid block = plateaus::turned(plateaus::block({80, 60, 30}, false), 30);
  const auto mold = make_mold(shapes::stl(block.mesh), "block.stl", settings, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_LT((mold->top - mold->placing(block.top)).head<2>().norm(), 0.3);
}

// Of two towers of one height the larger counts; of equal ones the nearer to the axis. A ring's middle is its hole.
TEST(MoldTop, OfSeveralPiecesIsTheLargestThenTheNearest) {
  const auto towers = [](double second, double at) {
    TriangleMesh mesh = shapes::box({-60, -10, 0}, {-40, 10, 50});
    const TriangleMesh other = shapes::box({at, -10, 0}, {at + second, 10, 50});
    for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    return mesh;
  };
  EXPECT_LT((top_of(towers(30, 40)) - Vector3d(55, 0, 50)).norm(), 1e-9);
  EXPECT_LT((top_of(towers(20, 35)) - Vector3d(45, 0, 50)).norm(), 1e-9);
  EXPECT_LT((top_of(towers(20, 55)) - Vector3d(-50, 0, 50)).norm(), 1e-9);
  const TriangleMesh tube = shapes::lathe({{0, 0}, {40, 0}, {40, 30}, {30, 30}, {30, 10}, {0, 10}}, 90);
  EXPECT_LT((top_of(shapes::moved(tube, Eigen::Affine3d(Eigen::Translation3d(3, 4, 0)))) - Vector3d(3, 4, 30))
                .norm(),
            1e-6);
}

}  // namespace
}  // namespace vacuform::mold_top_test
