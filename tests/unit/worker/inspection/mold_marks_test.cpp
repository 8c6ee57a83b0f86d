#include "worker/inspection/mold_marks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

// A straight prism on the platform, its outline counter-clockwise, closed by fans about (0, 0).
TriangleMesh prism(const std::vector<Eigen::Vector2d>& outline, double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (const double z : {0.0, height})
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(0, 0, height);
  for (int i = 0; i < n; ++i) {
    const int a = i, b = (i + 1) % n;
    mesh.triangles.push_back({a, b, b + n});
    mesh.triangles.push_back({a, b + n, a + n});
    mesh.triangles.push_back({2 * n, b, a});
    mesh.triangles.push_back({2 * n + 1, a + n, b + n});
  }
  return mesh;
}
std::vector<Eigen::Vector2d> ellipse(double a, double b) {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 64; ++i)
    outline.emplace_back(static_cast<float>(a * std::cos(i * M_PI / 32)),
                         static_cast<float>(b * std::sin(i * M_PI / 32)));
  return outline;
}

int corners_above_base(const TriangleMesh& mesh, double z) {
  return static_cast<int>(std::count_if(mesh.vertices.begin(), mesh.vertices.end(),
                                        [&](const Eigen::Vector3d& p) { return p.z() == z; }));
}

TEST(MoldMarks, AreFourSlotsInTheBaseTheLongOneTowardsT) {
  const TriangleMesh mold = prism(ellipse(40, 55), 30);
  ASSERT_TRUE(is_watertight(mold));
  const TriangleMesh marked = marked_mold(mold);
  EXPECT_TRUE(is_watertight(marked));
  EXPECT_NEAR(signed_volume(mold) - signed_volume(marked), 1.5 * (3 * 10 + 20), 1e-3);
  EXPECT_EQ(bounds(marked).low, bounds(mold).low);
  EXPECT_EQ(bounds(marked).high, bounds(mold).high);
  EXPECT_EQ(corners_above_base(marked, 1), 16);
  double farthest_t = 0, longest = 0;
  for (const auto& p : marked.vertices) {
    if (p.z() != 1) continue;
    EXPECT_NEAR(std::min(std::abs(p.x()), std::abs(p.y())), 0.75, 1e-6);
    farthest_t = std::max(farthest_t, p.y());
    for (const auto& q : marked.vertices)
      if (q.z() == 1 && q.x() == p.x() && q.y() > 0 && p.y() > 0 && std::abs(p.x()) < 1)
        longest = std::max(longest, q.y() - p.y());
    for (int k = 0; k < 3; ++k) EXPECT_EQ(p[k], static_cast<float>(p[k]));
  }
  EXPECT_NEAR(farthest_t, 52.5, 1e-4);
  EXPECT_NEAR(longest, 20, 1e-4);
  const TriangleMesh again = marked_mold(mold);
  EXPECT_EQ(again.triangles, marked.triangles);
}

TEST(MoldMarks, AreLeftOutWhereThereIsNoRoom) {
  // 22 mm deep: the long slot does not fit, and the short one only just not.
  const TriangleMesh narrow = prism(ellipse(40, 11), 30);
  const TriangleMesh marked = marked_mold(narrow);
  EXPECT_TRUE(is_watertight(marked));
  EXPECT_EQ(corners_above_base(marked, 1), 8);
  // Too flat for a slot with a millimetre above it.
  const TriangleMesh flat = prism(ellipse(40, 55), 1.5);
  EXPECT_EQ(marked_mold(flat).triangles, flat.triangles);
  // Nothing stands on the platform.
  TriangleMesh raised = prism(ellipse(40, 55), 30);
  for (auto& p : raised.vertices) p.z() += 2;
  EXPECT_EQ(marked_mold(raised).triangles, raised.triangles);
  EXPECT_TRUE(marked_mold({}).triangles.empty());
}

}  // namespace
}  // namespace vacuform
