#include "worker/sample/sample.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "api/base/sha256.hpp"

namespace vacuform {
namespace {

TEST(SampleHead, IsClosedAndTurnedOutwards) {
  const auto head = sample_head();
  std::set<std::pair<int, int>> edges;
  double volume = 0;
  for (const auto& t : head.triangles) {
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
    volume += head.vertices[t[0]].dot(head.vertices[t[1]].cross(head.vertices[t[2]])) / 6;
  }
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.count({b, a}));
  EXPECT_NEAR(volume, 3.070e6, 1e4);  // 3.1 litres with the neck
}

TEST(SampleHead, HasTheMeasuresOfItsSurvey) {
  Eigen::AlignedBox3d box;
  for (const auto& v : sample_head().vertices) box.extend(v);
  EXPECT_NEAR(box.sizes().x(), 152, 0.1);
  EXPECT_NEAR(box.sizes().y(), 195, 0.1);
  EXPECT_NEAR(box.sizes().z(), 183, 0.1);
  EXPECT_NEAR(box.min().z(), 0, 1e-9);
}

TEST(SampleHead, HasTheCircumferenceOfANewborn) {
  const auto head = sample_head(HeadForm::newborn);
  EXPECT_EQ(head.triangles, sample_head().triangles);
  // At the widest level, 95 of 183 of the height: ring 36 of 120 points.
  double around = 0;
  for (std::size_t i = 0; i < 120; ++i) {
    const auto &a = head.vertices[35 * 120 + i], &b = head.vertices[35 * 120 + (i + 1) % 120];
    EXPECT_NEAR(a.z(), 0.61 * 95, 1e-9);
    around += (b - a).norm();
  }
  EXPECT_NEAR(around, 344, 1);
}

TEST(SampleHead, HasNoUndercutAboveItsWidestLevelAndOneBelow) {
  const auto head = sample_head();
  bool under_below = false;
  for (const auto& t : head.triangles) {
    const auto &a = head.vertices[t[0]], &b = head.vertices[t[1]], &c = head.vertices[t[2]];
    const bool under = (b - a).cross(c - a).z() < -1e-9;
    if (std::min({a.z(), b.z(), c.z()}) >= 95 - 1e-9)
      EXPECT_FALSE(under) << "at height " << a.z();
    else if (a.z() > 1)
      under_below |= under;
  }
  EXPECT_TRUE(under_below);
}

TEST(SamplePattern, HasNineteenLoopsAtTheCriticalOverlap) {
  const auto svg = sample_pattern();
  EXPECT_NE(svg.find("width=\"185.9436mm\" height=\"167.6636mm\""), std::string::npos);
  for (int coil = 1; coil <= 19; ++coil)
    EXPECT_NE(svg.find("<g id=\"coil-" + std::to_string(coil) + "\">"), std::string::npos);
  EXPECT_EQ(svg.find("coil-20"), std::string::npos);
  // Coil 10 is the middle one; its neighbour in the row lies 0.75802 diameters away.
  EXPECT_NE(svg.find("<g id=\"coil-10\"><circle cx=\"0.0000\" cy=\"0.0000\" r=\"22.5000\""),
            std::string::npos);
  EXPECT_NE(svg.find("<g id=\"coil-11\"><circle cx=\"34.1109\" cy=\"0.0000\""), std::string::npos);
}

TEST(SamplePattern, HasTheBytesThatItHasAlwaysHad) {
  const std::string svg = sample_pattern();
  EXPECT_EQ(sha256_hex({reinterpret_cast<const std::uint8_t*>(svg.data()), svg.size()}),
            "3cbbc9004312d64f70fa6c04f0f0387ce504540b3df6686bb8b583de0e5840ed");
}

}  // namespace
}  // namespace vacuform
