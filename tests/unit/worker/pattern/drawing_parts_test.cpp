#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/ink_parts.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

// 60 x 40 mm at 10 pixels a millimetre: a ring, a square with a gray edge, a speck.
Pattern pattern() {
  const auto gray = [](int i, int j) {
    const Vector2d p((i + 0.5) / 10 - 30, 20 - (j + 0.5) / 10);
    const double ring = std::abs((p - Vector2d(-12, 4)).norm() - 10) - 1.5;
    const double square = (p - Vector2d(18, -6)).cwiseAbs().maxCoeff() - 5;
    const double speck = (p - Vector2d(18, 14)).norm() - 0.4;
    const double off = std::min({ring, square, speck});
    return static_cast<int>(255 * std::clamp(0.5 + off / 0.4, 0.0, 1.0));
  };
  auto read = Pattern::read(gray_png(600, 400, 10000, gray), "parts.png", {}, 300);
  if (!read) throw std::runtime_error(read.error().text());
  return std::move(*read);
}

// A wave of `width` mm along x, `thick` mm high everywhere, as a ring.
Ring wave(double width, double low, double thick) {
  constexpr int points = 1000;
  Ring ring;
  const auto at = [&](int i, double y) {
    ring.emplace_back(width * i / points, y + 0.3 * std::sin(0.1 * i));
  };
  for (int i = 0; i <= points; ++i) at(i, low);
  for (int i = points; i >= 0; --i) at(i, low + thick);
  return ring;
}

TEST(Area, UnitesLargePolygons) {
  std::vector<Ring> overlapping, apart;
  for (int k = 0; k < 50; ++k) {
    overlapping.push_back(wave(90, k, 1.2));
    apart.push_back(wave(90, 2 * k, 1.2));
  }
  const Area one = union_of(overlapping), many = union_of(apart);
  EXPECT_EQ(one.size(), 1u);
  EXPECT_NEAR(square_mm(one), 90 * 50.2, 1e-3);
  EXPECT_EQ(many.size(), 50u);
  EXPECT_NEAR(square_mm(many), 90 * 50 * 1.2, 0.02);  // points within 0.0005 mm of a line are left out
  double one_by_one = 0;                              // these are small, so they are not cut into strips
  for (const Ring& ring : apart) one_by_one += square_mm(union_of({ring}));
  EXPECT_NEAR(square_mm(many), one_by_one, 1e-3);
  // What each of the two halves shares with them.
  EXPECT_NEAR(square_mm(intersection(overlapping, {{{0, -9}, {45, -9}, {45, 99}, {0, 99}}})), 45 * 50.2,
              0.01);
}

TEST(Area, KeepsTheHolesOfLargePolygons) {
  std::vector<Ring> bars;
  for (int k = 0; k < 100; ++k) {
    const double low = k - 0.1, high = k + 0.1;
    bars.push_back({{low, -1}, {high, -1}, {high, 100}, {low, 100}});
    Ring row;  // with many points, so that it is cut
    for (int i = 0; i <= 1000; ++i) row.emplace_back(-1 + 0.101 * i, low);
    for (int i = 1000; i >= 0; --i) row.emplace_back(-1 + 0.101 * i, high);
    bars.push_back(row);
  }
  const Area lattice = union_of(bars);
  EXPECT_EQ(lattice.size(), 1u + 99 * 99);
  EXPECT_NEAR(square_mm(lattice), 2 * 100 * 101 * 0.2 - 1e4 * 0.04, 1e-3);
}

TEST(InkParts, AreTheConnectedInkWithItsOutlines) {
  const InkParts parts(pattern());
  const auto& elements = parts.drawing().elements;
  ASSERT_EQ(elements.size(), 2u);
  EXPECT_EQ(elements[0].id, "coil-1");
  EXPECT_LT((elements[0].centre - Vector2d(-12, 4)).norm(), 0.01);
  EXPECT_EQ(elements[1].id, "mark-1");
  EXPECT_LT((elements[1].centre - Vector2d(18, -6)).norm(), 0.01);
  ASSERT_EQ(elements[0].shapes[0].curves.size(), 2u);
  EXPECT_TRUE(elements[0].shapes[0].curves[0].closed);
  EXPECT_NEAR(square_mm(fill_area(elements[0].shapes[0].curves, true, 1e-3)), M_PI * 2 * 10 * 3, 0.3);
  EXPECT_NEAR(square_mm(fill_area(elements[1].shapes[0].curves, true, 1e-3)), 100, 0.3);
  for (const Vector2d& p : elements[0].shapes[0].curves[0].points)
    EXPECT_NEAR(std::abs((p - Vector2d(-12, 4)).norm() - 10), 1.5, 0.03);
}

TEST(InkParts, TakeTheirSmoothedEdgesWithThem) {
  const InkParts parts(pattern());
  EXPECT_TRUE(parts.holds(0, {-2, 4}));
  EXPECT_TRUE(parts.holds(0, {-0.2, 4}));
  EXPECT_TRUE(parts.holds(1, {18, -6}));
  EXPECT_TRUE(parts.holds(1, {18, -0.5}));
  EXPECT_TRUE(parts.holds(-1, {-12, 4}));
  EXPECT_TRUE(parts.holds(-1, {18, 14}));
  EXPECT_TRUE(parts.holds(-1, {1000, 0}));
  EXPECT_TRUE(parts.holds(-1, {NAN, 0}));
}

TEST(InkParts, ArePlacedWhereTheyMayBeAnArray) {
  std::vector<Warning> none;
  EXPECT_FALSE(parts_to_place(pattern(), PatternPlacement::chart, none));
  EXPECT_TRUE(parts_to_place(pattern(), PatternPlacement::automatic, none));
  const auto one = [](int side) {
    return std::move(
        *Pattern::read(gray_png(side, side, 1000, [](int, int) { return 0; }), "one.png", {}, 300));
  };
  EXPECT_TRUE(parts_to_place(one(50), PatternPlacement::automatic, none));
  EXPECT_FALSE(
      parts_to_place(one(151), PatternPlacement::automatic, none));  // too large for one neighbourhood
  EXPECT_TRUE(parts_to_place(one(50), PatternPlacement::elements, none));
}

// Seven rings of 40 mm that overlap as coils do, with a lead from one: each is found, to a twentieth of a millimetre, shares
// the ink where two cross, and the lead is in none.
TEST(InkParts, RingsThatOverlapAreToldApart) {
  std::vector<Vector2d> centres{{0, 0}};
  for (int k = 0; k < 6; ++k)
    centres.emplace_back(31 * std::cos(k * M_PI / 3 + 0.2), 31 * std::sin(k * M_PI / 3 + 0.2));
  const auto gray = [&](int i, int j) {
    const Vector2d p((i + 0.5) / 6 - 60, 60 - (j + 0.5) / 6);
    double off = std::max(std::abs(p.x()) - 0.8, std::abs(p.y() + 50) - 9);  // a lead
    for (const Vector2d& c : centres) off = std::min(off, std::abs((p - c).norm() - 20) - 1.5);
    return static_cast<int>(255 * std::clamp(0.5 + off * 6, 0.0, 1.0));
  };
  const auto read = Pattern::read(gray_png(720, 720, 6000, gray), "rings.png", {}, 300);
  ASSERT_TRUE(read);
  const InkParts parts(*read);
  const auto& elements = parts.drawing().elements;
  ASSERT_EQ(elements.size(), centres.size());
  EXPECT_FALSE(parts.entangled());
  for (const Vector2d& c : centres) {
    int found = 0;
    for (std::size_t e = 0; e < elements.size(); ++e) {
      if ((elements[e].centre - c).norm() > 0.05) continue;
      ++found;
      const auto box = box_of(elements[e].shapes[0].curves[0]);
      EXPECT_NEAR(box.sizes().x(), 43, 0.1);
      EXPECT_TRUE(parts.holds(static_cast<int>(e), c + Vector2d(20, 0)));
      EXPECT_TRUE(parts.holds(static_cast<int>(e), c + Vector2d(0, 21.4)));
      EXPECT_FALSE(parts.holds(static_cast<int>(e), c));
    }
    EXPECT_EQ(found, 1);
  }
  EXPECT_TRUE(parts.holds(-1, {0, -57}));
  std::vector<Warning> warnings;
  EXPECT_TRUE(parts_to_place(*read, PatternPlacement::automatic, warnings));
  EXPECT_TRUE(warnings.empty());
}

TEST(InkParts, OtherLoopsThatHangTogetherAreSaidTo) {
  const auto gray = [](int i, int j) {  // three squares side by side
    const Vector2d p((i + 0.5) / 6 - 50, 30 - (j + 0.5) / 6);
    double off = 1;
    for (const double x : {-28., 0., 28.})
      off = std::min(off, std::abs((p - Vector2d(x, 0)).cwiseAbs().maxCoeff() - 14) - 1);
    return off < 0 ? 0 : 255;
  };
  const auto read = Pattern::read(gray_png(600, 360, 6000, gray), "squares.png", {}, 300);
  ASSERT_TRUE(read);
  std::vector<Warning> warnings;
  const auto parts = parts_to_place(*read, PatternPlacement::automatic, warnings);
  ASSERT_TRUE(parts);
  EXPECT_EQ(parts->drawing().elements.size(), 1u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "ink-hangs-together");
}

}  // namespace
}  // namespace vacuform
