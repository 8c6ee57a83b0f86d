// A fast forming is closer to the exact one than the finer of the grids that it is made from, and keeps to the mold.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "tests/unit/fixtures/shapes.hpp"
#include "tests/unit/worker/forming/axisymmetric.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/interpolation.hpp"
#include "worker/forming/sheet_grid.hpp"
#include "worker/scan/mold_distance.hpp"

namespace vacuform::extrapolated_forming_test {
namespace {

constexpr double radius_mm = 85, ring = 1.5;

std::pair<SheetSettings, MachineSettings> clamped(double resolution_mm) {
  SheetSettings sheet;
  sheet.resolution_mm = resolution_mm;
  sheet.width_mm = sheet.height_mm = 2 * ring * radius_mm + 10;
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 2 * ring * radius_mm;
  return {sheet, machine};
}

FormedSheet formed_hemisphere(const Mold& mold, double resolution_mm, FormingQuality quality) {
  const auto [sheet, machine] = clamped(resolution_mm);
  FormingSettings forming;
  forming.law = MembraneLaw::neo_hookean;
  forming.quality = quality;
  auto formed = form(mold, sheet, machine, forming, TemperatureField(140), Context{});
  if (!formed) throw std::runtime_error(formed.error().text());
  return *std::move(formed);
}

// The number of its vertices that are on its grid: those between them come later.
std::size_t vertices_of_grid(double resolution_mm) {
  const auto [sheet, machine] = clamped(resolution_mm);
  return make_sheet_grid(sheet, machine).rest.size();
}

// Mean distance on the flat sheet between what lies on the mold and what belongs there.
double landing_error(const FormedSheet& sheet) {
  static const auto exact =
      exact::male_hemisphere(MembraneLaw::neo_hookean, ring, 81 * std::numbers::pi / 180);
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < sheet.rest.size(); ++i) {
    const Eigen::Vector3d& p = sheet.formed[i];
    const double polar = std::atan2(p.head<2>().norm(), p.z());
    if (sheet.contact[i] != Contact::mold || polar < 0.2 || polar > 1.3) continue;
    sum += std::abs(sheet.rest[i].norm() - exact::at(exact, polar).rest * radius_mm);
    ++count;
  }
  return sum / count;
}

TEST(FastForming, LandsCloserThanTheFinerOfItsGrids) {
  const Mold mold = hemisphere(radius_mm, 180, 360);
  const FormedSheet fast = formed_hemisphere(mold, 2, FormingQuality::fast);
  const double error = landing_error(fast),
               of_grid = landing_error(formed_hemisphere(mold, 4, FormingQuality::standard));
  EXPECT_LT(error, 0.7 * of_grid);
  EXPECT_LT(error, 0.05);
  ASSERT_TRUE(fast.summary.extrapolation);
  EXPECT_DOUBLE_EQ(fast.summary.extrapolation->coarse_mm, 8);
  EXPECT_DOUBLE_EQ(fast.summary.extrapolation->fine_mm, 4);
  EXPECT_GT(fast.summary.extrapolation->mean, 0);
  EXPECT_LT(fast.summary.extrapolation->p95, 0.2);
  ASSERT_FALSE(fast.warnings.empty());
  EXPECT_EQ(fast.warnings.back().code, "fast-forming");
}

TEST(FastForming, LiesOnTheMoldAndOnTheGridThatIsAskedFor) {
  const Mold mold = hemisphere(radius_mm, 180, 360);
  const FormedSheet fast = formed_hemisphere(mold, 3, FormingQuality::fast),
                    standard = formed_hemisphere(mold, 3, FormingQuality::standard);
  const MoldDistance distance(mold.mesh);
  int on_mold = 0, on_both = 0;
  for (std::size_t i = 0; i < vertices_of_grid(3); ++i) {
    EXPECT_EQ(fast.rest[i], standard.rest[i]);
    EXPECT_GE(fast.formed[i].z(), 0);
    if (fast.contact[i] != Contact::mold) continue;
    ++on_mold, on_both += standard.contact[i] == Contact::mold;
    EXPECT_LT(distance(fast.formed[i]), 1e-6);
    EXPECT_TRUE(fast.contact_time[i] >= 0 && fast.contact_time[i] <= 2);
  }
  EXPECT_GT(on_mold, 1000);
  EXPECT_GT(on_both, 0.98 * on_mold);
  EXPECT_NEAR(fast.fit.penetration.p99, standard.fit.penetration.p99, 0.01);
  EXPECT_TRUE(fast.fit.pierced.empty());
  EXPECT_LT(fast.summary.mass_error, 1e-9);
}

// What the frame holds stays flat, and the interpolation makes no folds of its own.
TEST(FastForming, FindsNoFoldsWhereTheStandardFindsNone) {
  const Mold mold = hemisphere(radius_mm, 180, 360);
  SheetSettings sheet;
  MachineSettings machine;
  FormingSettings forming;
  sheet.resolution_mm = 3;
  const auto standard = form(mold, sheet, machine, forming, TemperatureField(140), Context{});
  forming.quality = FormingQuality::fast;
  const auto fast = form(mold, sheet, machine, forming, TemperatureField(140), Context{});
  ASSERT_TRUE(standard && fast);
  const auto wrinkled = [](const FormedSheet& s) {
    return std::count(s.element_wrinkled.begin(), s.element_wrinkled.end(), 1);
  };
  EXPECT_EQ(wrinkled(*standard), 0);
  EXPECT_LT(wrinkled(*fast), 0.001 * static_cast<double>(fast->triangles.size()));
  for (std::size_t i = 0; i < fast->rest.size(); ++i)
    if (fast->rest[i].cwiseAbs().maxCoeff() >= machine.window_width_mm / 2) {
      EXPECT_EQ(fast->formed[i], standard->formed[i]);
    }
}

TEST(FastForming, GivesTheSameBytesTwice) {
  const Mold mold = hemisphere(radius_mm, 90, 180);
  const FormedSheet first = formed_hemisphere(mold, 3, FormingQuality::fast),
                    second = formed_hemisphere(mold, 3, FormingQuality::fast);
  EXPECT_EQ(first.formed, second.formed);
  EXPECT_EQ(first.contact, second.contact);
}

TEST(FineForming, HalvesTheSpacing) {
  const Mold mold = hemisphere(radius_mm, 90, 180);
  const FormedSheet fine = formed_hemisphere(mold, 10, FormingQuality::fine),
                    five = formed_hemisphere(mold, 5, FormingQuality::standard);
  EXPECT_EQ(fine.formed, five.formed);
}

// A window that leaves a margin of other spacing, so that the lines are not equidistant.
SheetGrid grid_of(double resolution_mm, WindowShape window) {
  SheetSettings sheet;
  sheet.width_mm = sheet.height_mm = 100;
  sheet.resolution_mm = resolution_mm;
  MachineSettings machine;
  machine.window = window;
  machine.window_width_mm = machine.window_height_mm = 83;
  return make_sheet_grid(sheet, machine);
}

TEST(SmoothInterpolation, ReproducesParabolasInsideAndLinesEverywhere) {
  const SheetGrid coarse = grid_of(7, WindowShape::rectangle), fine = grid_of(2, WindowShape::rectangle);
  const SmoothInterpolation interpolation(coarse, coarse.rest, fine.rest);
  const auto values = [](const Eigen::Vector2d& p) {
    return Eigen::Vector3d(p.x() * p.x() - 2 * p.x() * p.y(), 3 * p.x() - p.y() + 1, p.y() * p.y());
  };
  Points at(3, static_cast<Eigen::Index>(coarse.rest.size()));
  for (std::size_t i = 0; i < coarse.rest.size(); ++i)
    at.col(static_cast<Eigen::Index>(i)) = values(coarse.rest[i]);
  const Points there = interpolation(at);
  for (std::size_t i = 0; i < fine.rest.size(); ++i) {
    const Eigen::Vector3d wanted = values(fine.rest[i]), found = there.col(static_cast<Eigen::Index>(i));
    EXPECT_NEAR(found.y(), wanted.y(), 1e-9);
    if (fine.rest[i].cwiseAbs().maxCoeff() > 34) continue;  // a cell from the edges of the window
    EXPECT_NEAR(found.x(), wanted.x(), 1e-9);
    EXPECT_NEAR(found.z(), wanted.z(), 1e-9);
  }
}

TEST(SmoothInterpolation, KeepsTheKinkAtTheEdgesOfTheWindow) {
  const SheetGrid coarse = grid_of(7, WindowShape::rectangle), fine = grid_of(2, WindowShape::rectangle);
  const SmoothInterpolation interpolation(coarse, coarse.rest, fine.rest);
  const auto values = [](const Eigen::Vector2d& p) {
    return Eigen::Vector3d(std::max(std::abs(p.x()) - 41.5, 0.0), std::min(41.5 - std::abs(p.y()), 0.0), 1);
  };
  Points at(3, static_cast<Eigen::Index>(coarse.rest.size()));
  for (std::size_t i = 0; i < coarse.rest.size(); ++i)
    at.col(static_cast<Eigen::Index>(i)) = values(coarse.rest[i]);
  const Points there = interpolation(at);
  for (std::size_t i = 0; i < fine.rest.size(); ++i)
    EXPECT_LT((there.col(static_cast<Eigen::Index>(i)) - values(fine.rest[i])).norm(), 1e-9);
}

TEST(SmoothInterpolation, CountsVerticesOffTheirGridLinesWhereTheyAre) {
  const SheetGrid coarse = grid_of(7, WindowShape::circle), fine = grid_of(2, WindowShape::circle);
  const SmoothInterpolation interpolation(coarse, coarse.rest, fine.rest);
  Points at(3, static_cast<Eigen::Index>(coarse.rest.size()));
  for (std::size_t i = 0; i < coarse.rest.size(); ++i)
    at.col(static_cast<Eigen::Index>(i)) << coarse.rest[i], 2 * coarse.rest[i].x() - coarse.rest[i].y();
  const Points there = interpolation(at);
  double off = 0;
  for (std::size_t i = 0; i < fine.rest.size(); ++i)
    off = std::max(off, (there.col(static_cast<Eigen::Index>(i)).head<2>() - fine.rest[i]).norm());
  EXPECT_LT(off, 0.7);  // a tenth of the spacing, where vertices beside each other have been moved
}

}  // namespace
}  // namespace vacuform::extrapolated_forming_test
