#include "worker/sample/painted_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <utility>

#include "api/base/sha256.hpp"

namespace vacuform {
namespace {

class PaintedModels : public ::testing::TestWithParam<Model> {};

TEST_P(PaintedModels, AreClosedTurnedOutwardsAndWithoutAnUndercut) {
  const PaintedModel model = painted_model(GetParam());
  const auto& v = model.mesh.vertices;
  ASSERT_EQ(model.uv.size(), v.size());
  std::set<std::pair<int, int>> edges;
  for (const auto& t : model.mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
    const auto at = [&](std::size_t k) { return v[static_cast<std::size_t>(t[k])]; };
    const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0));
    EXPECT_GT(normal.norm(), 0);
    const bool below = at(0).z() == 0 && at(1).z() == 0 && at(2).z() == 0;
    if (below)
      EXPECT_LT(normal.z(), 0);
    else
      EXPECT_GT(normal.z(), -1e-9 * normal.norm());
  }
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.count({b, a}));
}

TEST_P(PaintedModels, HaveEachPlaceOnceOnTheTexture) {
  const PaintedModel model = painted_model(GetParam());
  for (const auto& t : model.mesh.triangles) {
    const auto place = [&](int k) {
      return model.uv[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    const auto vertex = [&](int k) {
      return model.mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    if (vertex(0).z() == 0 && vertex(1).z() == 0 && vertex(2).z() == 0) continue;  // below
    const Eigen::Vector2d a = place(1) - place(0), b = place(2) - place(0);
    EXPECT_LT(a.x() * b.y() - a.y() * b.x(), 0);  // v is down
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(place(k).minCoeff(), 0);
      EXPECT_LT(place(k).maxCoeff(), 1);
    }
  }
}

TEST_P(PaintedModels, HaveTheirLandmarksOnTheSurface) {
  const PaintedModel model = painted_model(GetParam());
  EXPECT_EQ(model.landmarks.size(), 10u);
  for (const Landmark& landmark : model.landmarks) {
    double nearest = 1e9;
    for (const auto& v : model.mesh.vertices) nearest = std::min(nearest, (v - landmark.place).norm());
    EXPECT_LT(nearest, 1.2) << landmark.label;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, PaintedModels, ::testing::Values(Model::mask, Model::figurine));

TEST(PaintedModel, HasItsSize) {
  Eigen::AlignedBox3d mask, figurine;
  for (const auto& v : painted_model(Model::mask).mesh.vertices) mask.extend(v);
  for (const auto& v : painted_model(Model::figurine).mesh.vertices) figurine.extend(v);
  EXPECT_LT((mask.sizes() - Eigen::Vector3d(144, 192, 73)).cwiseAbs().maxCoeff(), 0.5) << mask.sizes();
  EXPECT_LT((figurine.sizes() - Eigen::Vector3d(134, 197, 46)).cwiseAbs().maxCoeff(), 1) << figurine.sizes();
}

TEST(PaintedModel, IsTheSameFileTwice) {
  EXPECT_EQ(sha256_hex(painted_glb(Model::mask)), sha256_hex(painted_glb(Model::mask)));
}

}  // namespace
}  // namespace vacuform
