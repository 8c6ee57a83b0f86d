#include "worker/coils/decoupling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform::decoupling_test {
namespace {

using Eigen::Vector2d;
using hand_made::Sample;

Settings decoupled() {
  Settings settings;
  settings.coils.decouple = true;
  return settings;
}

Result<Placement> placed(const Sample& x, const Drawing& drawing, const Settings& settings = {}) {
  const hand_made::Charted charted(x);
  VACUFORM_TRY(placement, place(charted, &drawing, settings, Context()));
  VACUFORM_CHECK(add_couplings(charted, drawing, settings, Context(), placement));
  return placement;
}

double worst(const Placement& placement, std::optional<double> PlacedPair::*k) {
  double most = 0;
  for (const PlacedPair& pair : placement.pairs) most = std::max(most, std::abs(*(pair.*k)));
  return most;
}

TEST(Couplings, AreThoseOfThePlacementWithoutDecoupling) {
  const auto p = placed(hand_made::sphere(85, 240, 120), hand_made::seven_rings(20, 30.32));
  ASSERT_TRUE(p);
  ASSERT_EQ(p->pairs.size(), 12u);
  for (const PlacedPair& pair : p->pairs) {
    ASSERT_TRUE(pair.k);
    EXPECT_LT(std::abs(*pair.k), 0.02);
    EXPECT_EQ(pair.k, pair.k_before);
  }
}

TEST(Decoupling, OnASphereKeepsWithinTheLimit) {
  const Sample x = hand_made::sphere(70, 240, 120);
  Settings settings;
  settings.coils.decouple = true;
  const auto p = placed(x, hand_made::seven_rings(20, 30.32), settings);
  ASSERT_TRUE(p);
  double before = 0;
  for (const PlacedPair& pair : p->pairs) {
    before = std::max(before, std::abs(*pair.k_before));
    EXPECT_LT(std::abs(*pair.k), 0.002);
  }
  EXPECT_GT(before, 0.005);
  for (const PlacedElement& e : p->elements) EXPECT_LE(std::abs(e.size - 1), 0.05 + 1e-12);
  const auto again = placed(x, hand_made::seven_rings(20, 30.32), settings);
  for (std::size_t i = 0; i < p->elements.size(); ++i)
    EXPECT_EQ(p->elements[i].centre, again->elements[i].centre);
}

TEST(Decoupling, MovesThreeCoilsApartWithoutAWarning) {
  const Sample x = hand_made::flat(200, 80);
  Drawing drawing;
  drawing.elements = {hand_made::ring("a", {-12, 0}, 20), hand_made::ring("b", {12, 0}, 20),
                      hand_made::ring("c", {0, 20}, 20)};
  Settings settings;
  settings.coils.decouple = true;
  const auto free = placed(x, drawing, settings);
  ASSERT_TRUE(free);
  EXPECT_TRUE(free->warnings.empty());  // three coils can always be moved apart
  EXPECT_GT(free->elements[0].moved_mm, 1);
}

// Steps are taken on a layout that knows nothing of crossing geodesics; what counts is the one that is printed.
TEST(Decoupling, OnBumpsIsThatOfTheRealLayout) {
  const Sample x = hand_made::bumpy_sphere(70, 150, 75, 2);
  Drawing drawing;
  for (int i = 0; i < 3; ++i)
    drawing.elements.push_back(hand_made::ring("coil-" + std::to_string(i),
                                               17.5 * Vector2d(std::cos(2.1 * i), std::sin(2.1 * i)), 20));
  const auto p = placed(x, drawing, decoupled());
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
  const auto p = placed(x, drawing, settings);
  ASSERT_TRUE(p);
  ASSERT_EQ(p->pairs.size(), 14u);
  EXPECT_GE(worst(*p, &PlacedPair::k), 0.01);
  EXPECT_LT(worst(*p, &PlacedPair::k), worst(*p, &PlacedPair::k_before));
  const auto coupled = coupling_warning(coupled_loops(*p, drawing, Context()).value(), true);
  ASSERT_TRUE(coupled);
  EXPECT_EQ(coupled->code, "coils-coupled");
  for (const PlacedPair& pair : p->pairs) {
    const auto id = [&](int i) { return drawing.elements[static_cast<std::size_t>(i)].id; };
    const bool named = coupled->place.find(id(pair.a) + " and " + id(pair.b) + " (k = ") != std::string::npos;
    EXPECT_EQ(named, std::abs(*pair.k) >= 0.01) << id(pair.a) << ' ' << id(pair.b);
  }
}

// Four loops in a square: the two over the diagonals are no neighbours and nearly touch. They cannot be decoupled where
// they are, and say so.
TEST(Decoupling, CountsPairsThatAreNoNeighbours) {
  const Sample x = hand_made::flat(220, 60);
  Drawing drawing;
  drawing.elements = {hand_made::ring("a", {-15, -15}, 20), hand_made::ring("b", {15, -15}, 20),
                      hand_made::ring("c", {15, 15}, 20), hand_made::ring("d", {-15, 15}, 20)};
  for (const bool decouple : {false, true}) {
    const auto p = placed(x, drawing, decouple ? decoupled() : Settings());
    ASSERT_TRUE(p);
    ASSERT_EQ(p->pairs.size(), 4u);  // the sides
    const auto coupled = coupling_warning(coupled_loops(*p, drawing, Context()).value(), decouple);
    ASSERT_TRUE(coupled) << decouple;
    EXPECT_NE(coupled->text.find("2 pairs of "), std::string::npos) << coupled->text;
    for (const char* pair : {"a and c (k = -0.0", "b and d (k = -0.0"})
      EXPECT_NE(coupled->place.find(pair), std::string::npos) << coupled->place;
    EXPECT_LT(worst(*p, &PlacedPair::k), 0.011);
  }
}

// A loop beside two others, almost touching them: no neighbour overlaps it, and it is moved away.
TEST(Decoupling, MovesLoopsApartThatAlmostTouch) {
  const Sample x = hand_made::flat(220, 60);
  Drawing drawing;
  drawing.elements = {hand_made::ring("a", {-15, 0}, 20), hand_made::ring("b", {15, 0}, 20),
                      hand_made::ring("c", {2, 39}, 20)};
  const auto strongest = [&](const Settings& settings) {
    const auto p = placed(x, drawing, settings);
    double most = 0;
    const auto pairs = coupled_loops(*p, drawing, Context()).value();
    for (const CoupledLoops& pair : pairs) most = std::max(most, std::abs(pair.k));
    return most;
  };
  EXPECT_GT(strongest(Settings()), 0.04);
  EXPECT_LT(strongest(decoupled()), 0.03);
}

// Drawings that cannot be decoupled, by a fixed seed: no pair may end stronger than the strongest was, or than .03.
TEST(Decoupling, NeverEndsWorseThanItBegan) {
  std::mt19937 random(42);
  std::uniform_real_distribution<double> at(-38, 38), radius(12, 24);
  const Sample x = hand_made::sphere(75, 240, 80);
  for (int round = 0; round < 6; ++round) {
    Drawing drawing;
    for (int i = 0; i < 5; ++i)
      drawing.elements.push_back(
          hand_made::ring("coil-" + std::to_string(i), {at(random), at(random)}, radius(random)));
    const auto strongest = [&](const Settings& settings) {
      const auto p = placed(x, drawing, settings);
      double most = 0;
      const auto pairs = coupled_loops(*p, drawing, Context()).value();
      for (const CoupledLoops& pair : pairs) most = std::max(most, std::abs(pair.k));
      return most;
    };
    EXPECT_LE(strongest(decoupled()), std::max(0.03, strongest(Settings())) + 1e-9) << round;
  }
}

// An array is never so large; a drawing of nonsense is, and takes no hours.
TEST(Decoupling, LeavesMoreLoopsThanItTakesWhereTheyAreAndSaysSo) {
  const Sample x = hand_made::flat(220, 60);
  Drawing drawing;
  for (int i = 0; i < 17; ++i)
    for (int j = 0; j < 16; ++j)
      drawing.elements.push_back(hand_made::ring("coil-" + std::to_string(i) + "-" + std::to_string(j),
                                                 {7.5 * (i - 8), 7.5 * (j - 7)}, 5));
  const auto drawn = placed(x, drawing), p = placed(x, drawing, decoupled());
  ASSERT_TRUE(drawn && p);
  ASSERT_EQ(p->warnings.size(), 1u);
  EXPECT_EQ(p->warnings[0].code, "coils-not-decoupled");
  EXPECT_EQ(p->warnings[0].figure->value, 272);
  for (std::size_t i = 0; i < p->elements.size(); ++i)
    EXPECT_EQ(p->elements[i].centre, drawn->elements[i].centre) << i;
}

}  // namespace
}  // namespace vacuform::decoupling_test
