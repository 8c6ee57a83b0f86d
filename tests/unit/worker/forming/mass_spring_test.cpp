#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cstring>
#include <random>

#include "tests/unit/fixtures/shapes.hpp"
#include "tests/unit/worker/forming/both_integrators.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/settling.hpp"
#include "worker/sample/sample.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform::mass_spring_test {
namespace {

constexpr double young = 0.9e-3 * 1000, density = 1.27e-3, thickness = 0.5;  // N/mm^2, g/mm^3, mm

SheetGrid square(double side, double spacing) {
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = side;
  sheet.resolution_mm = spacing;
  MachineSettings machine;
  machine.window_width_mm = machine.window_height_mm = side;
  return make_sheet_grid(sheet, machine);
}

SpringNet net_of(const SheetGrid& grid, double factor = 1) {
  return {grid, std::vector<double>(grid.triangles.size(), factor), thickness, {young, density}};
}

Points flat(const SheetGrid& grid, const Eigen::Matrix2d& F = Eigen::Matrix2d::Identity()) {
  Points x = Points::Zero(3, static_cast<Eigen::Index>(grid.rest.size()));
  for (std::size_t i = 0; i < grid.rest.size(); ++i) x.col(i).head<2>() = F * grid.rest[i];
  return x;
}

Points still(const Points& x) { return Points::Zero(3, x.cols()); }

// Small homogeneous strains of the net: nothing is out of balance inside, and the forces on its right edge are those of
// an isotropic sheet of modulus E and Poisson's ratio 1/3.
TEST(SpringNet, StretchesAndShearsAsASheetOfItsModulus) {
  constexpr double side = 60, strain = 1e-5;
  const SheetGrid grid = square(side, 5);
  const SpringNet net = net_of(grid, 2);
  const double E = 2 * young * thickness;
  const auto edge_force = [&](const Eigen::Matrix2d& F) {
    const Points x = flat(grid, F);
    Points f;
    net.forces(x, still(x), 0, 0, f);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < grid.rest.size(); ++i) {
      if (!grid.clamped[i]) {
        EXPECT_LT(f.col(i).norm(), 1e-9 * E * strain);
      }
      if (grid.rest[i].x() > side / 2 - 1e-9) sum -= f.col(i);
    }
    return sum;
  };
  Eigen::Matrix2d wide = Eigen::Matrix2d::Identity(), sheared = wide;
  wide(0, 0) += strain;
  sheared(0, 1) = strain;
  EXPECT_NEAR(edge_force(wide).x(), E / (1 - 1.0 / 9) * strain * side, 1e-3 * E * strain * side);
  EXPECT_NEAR(edge_force(sheared).y(), E / (2 * (1 + 1.0 / 3)) * strain * side, 1e-3 * E * strain * side);
}

// A strip bent to a cylinder of curvature k: the bending springs hold half D k^2 for each unit of area.
TEST(SpringNet, BendsAsAPlate) {
  constexpr double side = 60, curvature = 1e-3;
  const SheetGrid grid = square(side, 5);
  const SpringNet net = net_of(grid);
  double energy = 0;
  for (const BendingSpring& s : net.bending_springs()) {
    const auto height = [&](int v) { return 0.5 * curvature * grid.rest[v].x() * grid.rest[v].x(); };
    const double bow = height(s.a) - 2 * height(s.middle) + height(s.b);
    energy += 0.5 * s.stiffness * bow * bow;
  }
  // The springs stand at the vertices between the edges: 11 of 12 cells along the strip.
  const double plate = young * thickness * thickness * thickness / 9;
  EXPECT_NEAR(energy, 0.5 * plate * curvature * curvature * side * (side - 5), 1e-9 * energy);
}

// A sheet of random places, some springs stretched and some compressed, under pressure, with a clamped edge.
struct Crumpled {
  Crumpled() : grid(square(40, 5)), net(net_of(grid).part(grid.clamped)) {
    std::mt19937 random(5);
    const auto noise = [&](double size) { return size * (2.0 * random() / std::mt19937::max() - 1); };
    x.resize(3, net.vertices());
    for (int i = 0; i < net.vertices(); ++i)
      x.col(i) << grid.rest[net.in_sheet()[i]] + Eigen::Vector2d(noise(1.5), noise(1.5)), noise(1.5);
    for (Points* direction : {&d, &e}) {
      *direction = still(x);
      for (int i = 0; i < net.moving(); ++i)
        direction->col(i) = Eigen::Vector3d(noise(1), noise(1), noise(1));
    }
  }
  // Central difference of the forces on the moving vertices along d.
  Points difference(double by_place, double by_velocity) const {
    constexpr double h = 1e-5;
    Points plus, minus;
    net.forces(x + h * by_place * d, h * by_velocity * d, p, 0, plus);
    net.forces(x - h * by_place * d, -h * by_velocity * d, p, 0, minus);
    return (plus - minus).leftCols(net.moving()) / (2 * h);
  }

  static constexpr double p = 0.02;
  SheetGrid grid;
  SpringNet net;
  Points x, d, e;
};

TEST(SpringNet, JacobiansAreThoseOfTheForces) {
  const Crumpled s;
  const SpringNet::Jacobian jacobian(s.net, s.x, s.p);
  Points product;
  jacobian.multiply(s.d, 1, 0, product);
  const Points by_place = s.difference(1, 0);
  EXPECT_LT((product.leftCols(s.net.moving()) - by_place).cwiseAbs().maxCoeff(), 1e-7 * by_place.norm());
  jacobian.multiply(s.d, 0, 1, product);
  const Points by_velocity = s.difference(0, 1);
  EXPECT_LT((product.leftCols(s.net.moving()) - by_velocity).cwiseAbs().maxCoeff(),
            1e-7 * by_velocity.norm());
}

TEST(SpringNet, JacobianIsSymmetric) {
  const Crumpled s;
  const SpringNet::Jacobian jacobian(s.net, s.x, s.p);
  Points of_d, of_e;
  jacobian.multiply(s.d, 1, 0.3, of_d);
  jacobian.multiply(s.e, 1, 0.3, of_e);
  const auto dot = [&](const Points& a, const Points& b) {
    return a.leftCols(s.net.moving()).cwiseProduct(b.leftCols(s.net.moving())).sum();
  };
  EXPECT_NEAR(dot(of_d, s.e), dot(of_e, s.d), 1e-12 * of_d.norm() * s.e.norm());
}

// The blocks for the preconditioner: those of the matrix where nothing is compressed, definite where something is.
TEST(SpringNet, BlocksOnTheDiagonal) {
  Crumpled s;
  for (const Eigen::Matrix3d& block : SpringNet::Jacobian(s.net, s.x, s.p).diagonal(1, 0.3))
    EXPECT_LT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(block).eigenvalues().maxCoeff(), 0);
  s.x *= 3;
  const SpringNet::Jacobian stretched(s.net, s.x, s.p);
  const auto blocks = stretched.diagonal(1, 0.3);
  for (int i = 0; i < s.net.moving(); ++i)
    for (int k = 0; k < 3; ++k) {
      Points unit = still(s.x), product;
      unit(k, i) = 1;
      stretched.multiply(unit, 1, 0.3, product);
      EXPECT_LT((product.col(i) - blocks[i].col(k)).norm(), 1e-12);
    }
}

TEST(SpringNet, ForcesAddUpToPressureAndWeight) {
  const SheetGrid grid = square(40, 5);
  const SpringNet net = net_of(grid);
  Points x = flat(grid), f;
  for (int i = 0; i < x.cols(); ++i) x(2, i) = 1e-2 * x(0, i) * x(1, i) - 5e-3 * x(0, i) * x(0, i);
  constexpr double p = 0.03, g = 9.81e-3;
  net.forces(x, still(x), p, g, f);
  EXPECT_NEAR(f.row(2).sum(), -1600 * (p + g * density * thickness), 1e-9);
  double mass = 0;
  for (double m : net.mass()) mass += m;
  EXPECT_NEAR(mass, 1600 * density * thickness, 1e-12);
}

TEST(SpringNet, APartFeelsWhatTheWholeFeels) {
  const SheetGrid grid = square(40, 5);
  const SpringNet net = net_of(grid);
  std::vector<char> held = grid.clamped;
  for (std::size_t i = 0; i < held.size(); ++i) held[i] = held[i] || grid.rest[i].norm() < 8;
  const SpringNet part = net.part(held);
  std::mt19937 random(3);
  Points x = flat(grid), v = still(x), of_net, of_part;
  for (int i = 0; i < x.size(); ++i) {
    x.data()[i] += 1e-9 * random();
    v.data()[i] += 1e-9 * random();
  }
  Points y(3, part.vertices()), w = y;
  for (int i = 0; i < part.vertices(); ++i)
    y.col(i) = x.col(part.in_sheet()[i]), w.col(i) = v.col(part.in_sheet()[i]);
  net.forces(x, v, 0.01, 1e-2, of_net);
  part.forces(y, w, 0.01, 1e-2, of_part);
  EXPECT_EQ(part.moving(), std::count(held.begin(), held.end(), 0));
  for (int i = 0; i < part.moving(); ++i)
    EXPECT_LT((of_part.col(i) - of_net.col(part.in_sheet()[i])).norm(), 1e-12);
}

// A clamped square under pressure.
class Inflation : public testing::Test {
 protected:
  Settling::Outcome settle(Integrator integrator, std::optional<double> step_ms) {
    x = Points(3, part.vertices());
    for (int i = 0; i < part.vertices(); ++i) x.col(i) << grid.rest[part.in_sheet()[i]], 0;
    const auto outcome =
        Settling(integrator, step_ms, 1e-6, 1).settle(part, x, {.pressure = 2e-3}, Context{}, 0);
    EXPECT_TRUE(outcome);
    return *outcome;
  }
  double limit() const {
    Points at_first(3, part.vertices());
    for (int i = 0; i < part.vertices(); ++i) at_first.col(i) << grid.rest[part.in_sheet()[i]], 0;
    return 2 / SpringNet::Jacobian(part, at_first, 0).highest_frequency();
  }

  const SheetGrid grid = square(100, 5);
  const SpringNet part = net_of(grid).part(grid.clamped);
  Points x;
};

TEST_F(Inflation, BothIntegratorsRestAtTheSamePlace) {
  const auto by_verlet = settle(Integrator::verlet, {});
  const Points rest = x;
  ASSERT_TRUE(by_verlet.at_rest);
  EXPECT_LT(rest.row(2).minCoeff(), -10);
  const auto by_euler = settle(Integrator::implicit_euler, {});
  ASSERT_TRUE(by_euler.at_rest);
  EXPECT_GT(by_euler.step_ms, 300 * by_verlet.step_ms);
  EXPECT_LT(5 * by_euler.steps, by_verlet.steps);
  EXPECT_LT((rest - x).colwise().norm().maxCoeff(), 1e-3);
}

TEST_F(Inflation, VerletBlowsUpWhereImplicitEulerRests) {
  const auto by_verlet = settle(Integrator::verlet, {});
  const Points rest = x;
  EXPECT_TRUE(settle(Integrator::verlet, 3 * limit()).blew_up);
  for (double times : {3.0, 100.0, 1e4}) {
    const auto by_euler = settle(Integrator::implicit_euler, times * limit());
    EXPECT_TRUE(by_euler.at_rest) << times;
    EXPECT_FALSE(by_euler.blew_up) << times;
    EXPECT_LT((rest - x).colwise().norm().maxCoeff(), 1e-3) << times;
  }
  EXPECT_TRUE(by_verlet.at_rest);
}

TEST(Settling, GivesUpWhenThereIsNoRest) {
  const SheetGrid grid = square(60, 15);
  const SpringNet part = net_of(grid).part(grid.clamped);
  Points x(3, part.vertices());
  for (int i = 0; i < part.vertices(); ++i) x.col(i) << grid.rest[part.in_sheet()[i]], 0;
  const auto outcome =
      Settling(Integrator::verlet, {}, 0, 1).settle(part, x, {.pressure = 2e-3}, Context{}, 0);
  ASSERT_TRUE(outcome);
  EXPECT_FALSE(outcome->at_rest);
  EXPECT_FALSE(outcome->blew_up);
  EXPECT_GT(outcome->steps, 2000);
}

// A cone on the platform, 60 mm high, or one sunk into a block, 60 degrees steep.
Mold cone(double radius, double tip, double rim) {
  constexpr int sectors = 180;
  Mold mold;
  auto& m = mold.mesh;
  m.vertices.push_back({0, 0, tip});
  const auto ring = [&](double r) {
    for (int j = 0; j < sectors; ++j) {
      const double around = 2 * std::numbers::pi * j / sectors;
      m.vertices.push_back({r * std::cos(around), r * std::sin(around), rim});
    }
  };
  ring(radius), ring(2 * radius);
  for (int j = 0; j < sectors; ++j) {
    const int a = 1 + j, b = 1 + (j + 1) % sectors;
    m.triangles.push_back({0, a, b});
    if (tip > rim) continue;
    m.triangles.push_back({a, a + sectors, b + sectors});
    m.triangles.push_back({a, b + sectors, b});
  }
  mold.top = {0, 0, std::max(tip, rim)};
  return mold;
}

TEST(MassSpring, BothIntegratorsFormTheSameMaleCone) {
  const Mold mold = cone(50, 60, 0);
  Machine m = round_machine(160, 6);
  EXPECT_LT(apart(mold, m), 0.01);
  const auto formed = formed_by(mold, m, Integrator::implicit_euler);
  ASSERT_TRUE(formed);
  int on_mold = 0;
  for (std::size_t i = 0; i < formed->formed.size(); ++i)
    if (formed->contact[i] == Contact::mold) {
      ++on_mold;
      const auto& p = formed->formed[i];
      EXPECT_NEAR(p.head<2>().norm() / 50 + p.z() / 60, 1, 1e-3);
    }
  EXPECT_GT(on_mold, 200);
}

TEST(MassSpring, BothIntegratorsFormTheSameFemaleCone) {
  Machine m = round_machine(80, 4);
  m.machine.drape_height_mm = 40 * std::tan(std::numbers::pi / 3);
  const Mold mold = cone(40, 0, m.machine.drape_height_mm);
  EXPECT_LT(apart(mold, m), 0.01);
}

TEST(MassSpring, BothIntegratorsFormTheSameHead) {
  const auto mold = make_mold(stl_bytes(sample_head(HeadForm::newborn)), "newborn.stl", {}, Context{});
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_LT(apart(*mold, head_machine()), 0.1);
}

TEST(MassSpring, ALongTimeStepIsForImplicitEulerAlone) {
  Machine m = round_machine(160, 8);
  m.forming.time_step_ms = 1;  // several times Verlet's limit
  const Mold mold = hemisphere(50);
  const auto by_verlet = formed_by(mold, m, Integrator::verlet);
  ASSERT_FALSE(by_verlet);
  EXPECT_EQ(by_verlet.error().code, Code::forming_failed);
  EXPECT_EQ(by_verlet.error().where, "forming.time_step_ms");
  const auto by_euler = formed_by(mold, m, Integrator::implicit_euler);
  ASSERT_TRUE(by_euler) << by_euler.error().text();
  EXPECT_TRUE(by_euler->summary.converged);
}

// Rheology is last: over a hemisphere of R = 85 mm under a ring of 1.5 R the net lands within a millimetre of the
// neo-Hookean membrane.
TEST(MassSpring, LandsNearTheMembrane) {
  constexpr double R = 85;
  Machine m = round_machine(3 * R, 6);
  const auto formed = formed_by(hemisphere(R), m, Integrator::implicit_euler);
  ASSERT_TRUE(formed) << formed.error().text();
  constexpr std::array<std::array<double, 2>, 7> reference{
      {{0, 0}, {15, .2594}, {30, .5032}, {45, .7132}, {60, .8913}, {75, 1.0618}, {85, 1.1586}}};
  double worst = 0;
  int compared = 0;
  for (std::size_t i = 0; i < formed->formed.size(); ++i) {
    if (formed->contact[i] != Contact::mold) continue;
    const auto& p = formed->formed[i];
    const double polar = std::atan2(p.head<2>().norm(), p.z()) * 180 / std::numbers::pi;
    for (const auto& [angle, landed] : reference)
      if (std::abs(polar - angle) < 0.2) {
        // A degree of polar angle is about R / 60 of the sheet.
        const double there = formed->rest[i].norm() - (polar - angle) * R / 60;
        worst = std::max(worst, std::abs(there - landed * R));
        ++compared;
      }
  }
  EXPECT_GT(compared, 20);
  EXPECT_LT(worst, 1);
}

// The same way at other time steps ends at the same place.
TEST(MassSpring, TheTimeStepOfImplicitEulerDoesNotMoveTheSheet) {
  const Mold mold = hemisphere(50);
  Machine m = round_machine(160, 8);
  const auto chosen = formed_by(mold, m, Integrator::implicit_euler);
  ASSERT_TRUE(chosen);
  for (double ms : {5.0, 500.0}) {
    m.forming.time_step_ms = ms;
    const auto other = formed_by(mold, m, Integrator::implicit_euler);
    ASSERT_TRUE(other) << ms;
    for (std::size_t i = 0; i < grid_vertices(m); ++i)
      ASSERT_LT((chosen->formed[i] - other->formed[i]).norm(), 0.01) << ms;
  }
}

// The sag of an elastic sheet is taken back where the mold lifts it, so it moves the landing by little.
TEST(MassSpring, SagComesBeforeTheMold) {
  const Mold mold = hemisphere(50);
  Machine m = round_machine(160, 8);
  const auto taut = formed_by(mold, m, Integrator::implicit_euler);
  m.forming.sag = true;
  const auto sagging = formed_by(mold, m, Integrator::implicit_euler);
  ASSERT_TRUE(taut && sagging);
  EXPECT_TRUE(sagging->summary.converged);
  EXPECT_LT(sagging->summary.force_error, 1e-5);
  double moved = 0;
  for (std::size_t i = 0; i < grid_vertices(m); ++i)
    moved = std::max(moved, (taut->formed[i] - sagging->formed[i]).norm());
  EXPECT_GT(moved, 0.01);
  EXPECT_LT(moved, 1);
}

TEST(MassSpring, SameInputSameBytes) {
  const Machine m = round_machine(160, 8);
  const auto a = formed_by(hemisphere(50), m, Integrator::implicit_euler),
             b = formed_by(hemisphere(50), m, Integrator::implicit_euler);
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->formed.size(), b->formed.size());
  EXPECT_EQ(std::memcmp(a->formed.data(), b->formed.data(), a->formed.size() * sizeof(Eigen::Vector3d)), 0);
}

// Progress rises, and a cancellation from its listener ends the work at once.
TEST(MassSpring, ReportsAndCanBeCancelled) {
  for (const auto integrator : {Integrator::implicit_euler, Integrator::verlet}) {
    Machine m = round_machine(160, 5);
    m.forming.integrator = integrator;
    double last = 0;
    Context* handle = nullptr;
    Context context([&](Stage, double fraction) {
      EXPECT_GE(fraction, last);
      last = fraction;
      if (fraction > 0.2) handle->cancel();
    });
    handle = &context;
    const auto formed = form(hemisphere(50), m.sheet, m.machine, m.forming, warm, context);
    ASSERT_FALSE(formed);
    EXPECT_EQ(formed.error().code, Code::cancelled);
    EXPECT_GT(last, 0.2);
    EXPECT_LT(last, 0.3);
  }
}

}  // namespace
}  // namespace vacuform::mass_spring_test
