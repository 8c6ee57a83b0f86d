#include "worker/forming/membrane.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "worker/forming/equilibrium.hpp"
#include "worker/forming/free_membrane.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform::membrane_test {
namespace {

constexpr MembraneLaw laws[] = {MembraneLaw::neo_hookean, MembraneLaw::mooney_rivlin};

TEST(Density, DerivativesMatchDifferences) {
  for (const MembraneLaw law : laws)
    for (const double l1 : {1.05, 1.4, 2.5})
      for (const double l2 : {0.3, 0.7, 1.02}) {
        constexpr double e = 1e-6;
        const Density d = density(law, l1, l2);
        const auto plus = density(law, l1 + e, l2), minus = density(law, l1 - e, l2);
        const auto up = density(law, l1, l2 + e), down = density(law, l1, l2 - e);
        EXPECT_NEAR(d.W1, (plus.W - minus.W) / (2 * e), 1e-7) << l1 << " " << l2;
        EXPECT_NEAR(d.W2, (up.W - down.W) / (2 * e), 1e-7) << l1 << " " << l2;
        EXPECT_NEAR(d.W11, (plus.W1 - minus.W1) / (2 * e), 1e-6) << l1 << " " << l2;
        EXPECT_NEAR(d.W22, (up.W2 - down.W2) / (2 * e), 1e-6) << l1 << " " << l2;
        EXPECT_NEAR(d.W12, (up.W1 - down.W1) / (2 * e), 1e-6) << l1 << " " << l2;
      }
}

// The relaxed energy goes over smoothly where the sheet begins to wrinkle, and pushes nowhere.
TEST(Density, WrinklesCarryTensionOnly) {
  for (const MembraneLaw law : laws) {
    const double l1 = 1.6, natural = 1 / std::sqrt(l1);
    EXPECT_NEAR(density(law, l1, natural + 1e-9).W, density(law, l1, natural - 1e-9).W, 1e-9);
    EXPECT_NEAR(density(law, l1, natural + 1e-9).W1, density(law, l1, natural - 1e-9).W1, 1e-7);
    const Density wrinkled = density(law, l1, 0.5 * natural);
    EXPECT_TRUE(wrinkled.wrinkled);
    EXPECT_GT(wrinkled.W1, 0.9);
    EXPECT_NEAR(wrinkled.W2, 0, 0.02);
    EXPECT_FALSE(density(law, l1, 1.0).wrinkled);
  }
}

TEST(Membrane, GradientMatchesDifferences) {
  const std::vector<Eigen::Vector2d> rest{{0, 0}, {2, 0.1}, {2.2, 1.9}, {-0.1, 2}, {1, 1}};
  const std::vector<Triangle> triangles{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.3, 0.3);
  for (const MembraneLaw law : laws) {
    const Membrane membrane(rest, triangles, law, {1, 2, 0.5, 1});
    Points x(3, 5), g(3, 5), unused(3, 5);
    for (int i = 0; i < 5; ++i)
      x.col(i) << 1.3 * rest[i].x() + noise(random), 0.8 * rest[i].y() + noise(random), noise(random);
    membrane.energy(x, 0.37, g);
    // The pressure's gradient is exact at vertices inside the sheet; vertex 4 is the one.
    for (int k = 0; k < 3; ++k) {
      constexpr double e = 1e-6;
      Points plus = x, minus = x;
      plus(k, 4) += e, minus(k, 4) -= e;
      const double difference =
          (membrane.energy(plus, 0.37, unused) - membrane.energy(minus, 0.37, unused)) / (2 * e);
      EXPECT_NEAR(g(k, 4), difference, 1e-7 * (1 + std::abs(difference)));
    }
    // Without pressure it is exact everywhere, and no force or torque is left over.
    membrane.energy(x, 0, g);
    for (int v = 0; v < 5; ++v)
      for (int k = 0; k < 3; ++k) {
        constexpr double e = 1e-6;
        Points plus = x, minus = x;
        plus(k, v) += e, minus(k, v) -= e;
        const double difference =
            (membrane.energy(plus, 0, unused) - membrane.energy(minus, 0, unused)) / (2 * e);
        EXPECT_NEAR(g(k, v), difference, 1e-7 * (1 + std::abs(difference)));
      }
    EXPECT_LT(g.rowwise().sum().norm(), 1e-12);
  }
}

// The pressure in a spherical balloon of radius R and thickness h is h / R times (dW/dl) / l^2: it never falls with a law
// that hardens, so no part of a sheet can take all the stretch of its neighbours at a pressure that they bear.
TEST(Density, TheDefaultLawHardensAndNeoHookeanDoesNot) {
  const auto pressure = [](MembraneLaw law, double l) {
    const Density d = density(law, l, l);
    return (d.W1 + d.W2) / (l * l);
  };
  const auto falls = [&](MembraneLaw law) {
    double first = 0;
    for (double l = 1.01; l < 10 && first == 0; l += 0.01)
      if (pressure(law, l + 0.01) < pressure(law, l)) first = l;
    return first;
  };
  EXPECT_EQ(falls(FormingSettings{}.law), 0);
  EXPECT_NEAR(falls(MembraneLaw::neo_hookean), std::pow(7, 1.0 / 6), 0.02);
}

// A uniform biaxial stretch of the sheet by l costs A (l^2 + 1 / (2 l^4) - 3/2) with the neo-Hookean law.
TEST(Membrane, UniformStretchCostsWhatTheLawSays) {
  SheetSettings sheet;
  sheet.resolution_mm = 3;  // the rounding of a sum grows with its terms
  const auto grid = make_sheet_grid(sheet, {});
  const Membrane membrane(grid.rest, grid.triangles, MembraneLaw::neo_hookean,
                          std::vector<double>(grid.triangles.size(), 1));
  Points x(3, static_cast<Eigen::Index>(grid.rest.size())), g = x;
  const double l = 1.7;
  for (std::size_t i = 0; i < grid.rest.size(); ++i) x.col(i) << l * grid.rest[i], 0;
  const double area = 300.0 * 300.0;
  EXPECT_NEAR(membrane.energy(x, 0, g) / area, l * l + 0.5 / std::pow(l, 4) - 1.5, 1e-12);
  EXPECT_NEAR(membrane.area_stretch(x, 0), l * l, 1e-12);
  EXPECT_FALSE(membrane.wrinkled(x, 0));
}

// A sheet that is tight, wrinkled or crushed, on a grid with and without threads, gives the same energy and gradient
// packed as triangle by triangle, and the same bytes with and without AVX2.
TEST(FreeMembrane, EqualsTheMembraneWhereNothingTouches) {
  for (const double resolution : {1.5, 6.0}) {
    SheetSettings sheet;
    sheet.resolution_mm = resolution;
    const auto grid = make_sheet_grid(sheet, {});
    std::vector<char> held = grid.clamped;
    for (std::size_t i = 0; i < held.size(); ++i)
      if (grid.rest[i].norm() < 40) held[i] = 1;
    for (const MembraneLaw law : laws)
      for (const double narrow : {1.2, 0.7, 0.05}) {
        const Membrane membrane(grid.rest, grid.triangles, law,
                                std::vector<double>(grid.triangles.size(), 1.5));
        Points x(3, static_cast<Eigen::Index>(grid.rest.size())), expected = x;
        for (std::size_t i = 0; i < grid.rest.size(); ++i) {
          const auto& p = grid.rest[i];
          x.col(i) << 1.4 * p.x(), narrow * p.y() + 0.1 * p.x() * narrow, 0.002 * p.x() * p.x();
        }
        membrane.energy(x, 0.3, expected);
        FreeMembrane packed;
        packed.pack(membrane, grid, held);
        std::vector<Column> place, gradient;
        for (const int v : packed.vertices()) place.emplace_back(x(0, v), x(1, v), x(2, v), 0);
        const double energy = packed.energy(place, 0.3, gradient);
        FreeMembrane narrow_registers(false);
        narrow_registers.pack(membrane, grid, held);
        std::vector<Column> same;
        EXPECT_EQ(narrow_registers.energy(place, 0.3, same), energy);
        EXPECT_EQ(std::memcmp(same.data(), gradient.data(), gradient.size() * sizeof(Column)), 0);
        ASSERT_EQ(static_cast<int>(gradient.size()), packed.free());
        const double scale = expected.colwise().norm().maxCoeff();
        for (int k = 0; k < packed.free(); ++k)
          ASSERT_LT((gradient[k].head<3>().matrix() - expected.col(packed.vertices()[k])).norm(),
                    1e-9 * scale)
              << narrow << " " << k;

        // All of the energy but that of the triangles between held vertices, which does not change with the free ones.
        Points moved = x;
        for (int k = 0; k < packed.free(); ++k) {
          place[k][0] *= 1.01;
          moved(0, packed.vertices()[k]) *= 1.01;
        }
        const double difference = membrane.energy(moved, 0.3, expected) - membrane.energy(x, 0.3, expected);
        EXPECT_NEAR(packed.energy(place, 0.3, gradient) - energy, difference, 1e-9 * std::abs(energy))
            << narrow;
      }
  }
}

// A balloon of a Newtonian sheet, exact: 1 / r^3 = 1 / r0^3 - p t / (4 viscosity h0 r0^2). Every patch of it stretches the
// same both ways, so the energy of a flat patch is that of the balloon per area.
TEST(Membrane, AViscousBalloonGrowsAsTheExactOne) {
  const std::vector<Eigen::Vector2d> rest{{0, 0}, {1, 0}, {0, 1}};
  Membrane patch(rest, {{0, 1, 2}}, MembraneLaw::neo_hookean, {1.0});
  Points x(3, 3), g(3, 3);
  const auto energy = [&](double l) {  // per rest area
    for (int i = 0; i < 3; ++i) x.col(i) << l * rest[i], 0;
    return 2 * patch.energy(x, 0, g);
  };
  // r0 = h0 = viscosity = 1: over dt the modulus is 1 / dt, and rest holds where d(4 pi W) / dl = p 4 pi l^2.
  const double p = 0.5, dt = 1e-3;
  double l = 1, t = 0;
  while (t < 5) {
    double low = l, high = 1.1 * l;
    for (int k = 0; k < 50; ++k) {
      const double middle = (low + high) / 2, e = 1e-5;
      const double resisting = (energy(middle + e) - energy(middle - e)) / (2 * e) / dt;
      (resisting < p * middle * middle ? low : high) = middle;
    }
    l = low, t += dt;
    energy(l);
    patch.flow(x, 0, 0);
    EXPECT_NEAR(patch.area_stretch(x, 0), l * l, 1e-12);
  }
  EXPECT_NEAR(1 / std::pow(l, 3), 1 - p * t / 4, 2e-3);
}

TEST(Membrane, KeepsAPowerOfItsStretchWhenItFlows) {
  const std::vector<Eigen::Vector2d> rest{{0, 0}, {2, 0.3}, {0.1, 1}};
  Membrane patch(rest, {{0, 1, 2}}, MembraneLaw::neo_hookean, {1.0});
  Points x(3, 3), g(3, 3);
  for (int i = 0; i < 3; ++i)
    x.col(i) << 1.6 * rest[i].x() + 0.2 * rest[i].y(), 1.3 * rest[i].y(), 0.4 * rest[i].x();
  const double before = patch.equivalent_stress(x, 0);
  patch.flow(x, 0, 0.5);
  const double half = patch.equivalent_stress(x, 0);
  EXPECT_LT(half, 0.7 * before);
  EXPECT_GT(half, 0.3 * before);
  patch.flow(x, 0, 0);
  EXPECT_NEAR(patch.equivalent_stress(x, 0), 0, 1e-12);
  EXPECT_NEAR(patch.energy(x, 0, g), 0, 1e-12);
}

TEST(Membrane, FlowsToTheStressThatIsAskedFor) {
  const std::vector<Eigen::Vector2d> rest{{0, 0}, {2, 0}, {0, 1}};
  for (const double stretch : {1.2, 2.0, 2.5})
    for (const double left : {0.9, 0.5, 0.1}) {
      Membrane patch(rest, {{0, 1, 2}}, MembraneLaw::neo_hookean, {1.0});
      Points x = Points::Zero(3, 3);
      x(0, 1) = 2 * stretch, x(1, 2) = 1;
      const double wanted = left * patch.equivalent_stress(x, 0);
      patch.flow(x, 0, patch.kept_at_stress(x, 0, wanted));
      EXPECT_NEAR(patch.equivalent_stress(x, 0), wanted, 1e-9) << stretch << ' ' << left;
      EXPECT_EQ(patch.kept_at_stress(x, 0, 2 * wanted), 1);
    }
}

// Reference of a clamped circular neo-Hookean membrane: at p a / (mu h0) = 1.1715 it rises to 0.5878 a, its pole is
// thinned to 0.640 and its edge to 0.830 of h0; at 0.5278 to 0.3835, 0.826 and 0.906.
class Inflation : public testing::TestWithParam<std::array<double, 4>> {};
TEST_P(Inflation, RisesAndThinsAsTheReference) {
  const auto [pressure, rise, pole, edge] = GetParam();
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = 210;
  sheet.resolution_mm = 5;
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 200;
  const auto grid = make_sheet_grid(sheet, machine);
  const Membrane membrane(grid.rest, grid.triangles, MembraneLaw::neo_hookean,
                          std::vector<double>(grid.triangles.size(), 1));
  Equilibrium equilibrium(membrane, grid);
  Points x(3, static_cast<Eigen::Index>(grid.rest.size()));
  for (std::size_t i = 0; i < grid.rest.size(); ++i) x.col(i) << grid.rest[i], 0;
  Equilibrium::Outcome outcome;
  for (int step = 1; step <= 10; ++step) {
    equilibrium.hold(grid.clamped, x);
    const double p = pressure / 100 * step / 10;
    Equilibrium::Limits limits;
    limits.force = 1e-5 * p * 25;
    limits.iterations = 2000;
    outcome = equilibrium.solve(x, {p, 0}, limits, Context{});
  }
  EXPECT_TRUE(outcome.at_rest);
  EXPECT_NEAR(-x.row(2).minCoeff() / 100, rise, 0.01 * rise);
  double thinnest = 1, at_edge = 0;
  int edge_triangles = 0;
  for (std::size_t k = 0; k < grid.triangles.size(); ++k) {
    const Triangle& t = grid.triangles[k];
    const double thickness = 1 / membrane.area_stretch(x, static_cast<int>(k));
    const double radius = ((grid.rest[t[0]] + grid.rest[t[1]] + grid.rest[t[2]]) / 3).norm();
    thinnest = std::min(thinnest, thickness);
    if (radius > 97 && radius < 100) at_edge += thickness, ++edge_triangles;
  }
  EXPECT_NEAR(thinnest, pole, 0.01 * pole);
  EXPECT_NEAR(at_edge / edge_triangles, edge, 0.01 * edge);
}
INSTANTIATE_TEST_SUITE_P(Reference, Inflation,
                         testing::Values(std::array{0.5278, 0.3835, 0.826, 0.906},
                                         std::array{1.1715, 0.5878, 0.640, 0.830}));

}  // namespace
}  // namespace vacuform::membrane_test
