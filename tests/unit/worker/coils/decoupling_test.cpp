#include "worker/coils/decoupling.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/coils/coupling_warning.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using hand_made::Sample;

Settings decoupled() {
  Settings settings;
  settings.coils.decouple = true;
  return settings;
}

double worst(const Placement& placement, std::optional<double> PlacedPair::*k) {
  double most = 0;
  for (const PlacedPair& pair : placement.pairs) most = std::max(most, std::abs(*(pair.*k)));
  return most;
}

// Steps are taken on a layout that knows nothing of crossing geodesics; what counts is the one that is printed.
TEST(Decoupling, OnBumpsIsThatOfTheRealLayout) {
  const Sample x = hand_made::bumpy_sphere(70, 150, 75, 2);
  Drawing drawing;
  for (int i = 0; i < 3; ++i)
    drawing.elements.push_back(hand_made::ring("coil-" + std::to_string(i),
                                               17.5 * Vector2d(std::cos(2.1 * i), std::sin(2.1 * i)), 20));
  const auto p = place(hand_made::Charted(x), &drawing, decoupled(), Context());
  ASSERT_TRUE(p);
  EXPECT_TRUE(
      std::any_of(p->elements.begin(), p->elements.end(), [](const PlacedElement& e) { return !e.smooth; }));
  ASSERT_EQ(p->pairs.size(), 3u);
  EXPECT_GT(worst(*p, &PlacedPair::k_before), 0.02);
  EXPECT_LT(worst(*p, &PlacedPair::k), 0.003);
}

// Seven loops around one: in the plane their sides come out shorter than their spokes, and no size may give way.
TEST(Decoupling, SaysWhichPairsTheSurfaceKeepsCoupled) {
  const Sample x = hand_made::flat(220, 60);
  Drawing drawing;
  drawing.elements.push_back(hand_made::ring("middle", {0, 0}, 20));
  for (int i = 0; i < 7; ++i) {
    const double angle = 2 * M_PI * i / 7;
    drawing.elements.push_back(
        hand_made::ring("rim-" + std::to_string(i + 1), 32 * Vector2d(std::cos(angle), std::sin(angle)), 20));
  }
  Settings settings = decoupled();
  settings.coils.size_limit = 0;
  const auto p = place(hand_made::Charted(x), &drawing, settings, Context());
  ASSERT_TRUE(p);
  ASSERT_EQ(p->pairs.size(), 14u);
  EXPECT_GE(worst(*p, &PlacedPair::k), 0.01);
  EXPECT_LT(worst(*p, &PlacedPair::k), worst(*p, &PlacedPair::k_before));
  const auto coupled = coupling_warning(coupled_neighbours(*p, drawing), true);
  ASSERT_TRUE(coupled);
  EXPECT_EQ(coupled->code, "coils-coupled");
  for (const PlacedPair& pair : p->pairs) {
    const auto id = [&](int i) { return drawing.elements[static_cast<std::size_t>(i)].id; };
    const bool named = coupled->place.find(id(pair.a) + " and " + id(pair.b) + " (k = ") != std::string::npos;
    EXPECT_EQ(named, std::abs(*pair.k) >= 0.01) << id(pair.a) << ' ' << id(pair.b);
  }
}

}  // namespace
}  // namespace vacuform
