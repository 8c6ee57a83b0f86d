#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform::projection_test {
namespace {

// Over a hemisphere every vertex keeps its place in the plane, and its height is that of the sphere or the platform.
TEST(Projection, EveryVertexGoesStraightDown) {
  constexpr double R = 61;  // no vertex lands on its rim
  SheetSettings sheet;
  sheet.resolution_mm = 5;
  MachineSettings machine;
  machine.drape_height_mm = 20;
  FormingSettings settings;
  settings.model = FormingModel::projection;
  const auto formed =
      form(hemisphere(R, 180, 360), sheet, machine, settings, TemperatureField(140), Context{});
  ASSERT_TRUE(formed) << formed.error().text();
  int on_mold = 0, on_platform = 0;
  for (std::size_t i = 0; i < formed->rest.size(); ++i) {
    const auto& p = formed->formed[i];
    const double r = formed->rest[i].norm(), time = formed->contact_time[i];
    EXPECT_LT((p.head<2>() - formed->rest[i]).norm(), 1e-5);
    switch (formed->contact[i]) {
      case Contact::mold: {
        ++on_mold;
        const double z = std::sqrt(R * R - r * r);
        EXPECT_NEAR(p.z(), z, 0.02 + 1e-4 * R * R / std::max(1.0, z));
        // The frame passes at this height, or has stopped above it.
        EXPECT_NEAR(time, p.z() > 20 ? (R - p.z()) / (R - 20) : 2 - p.z() / 20, 1e-3);
        break;
      }
      case Contact::platform:
        ++on_platform;
        EXPECT_GE(r, R - 0.02);
        EXPECT_EQ(p.z(), 0);
        EXPECT_NEAR(time, 2, 1e-3);
        break;
      case Contact::clamp:
        EXPECT_GE(formed->rest[i].cwiseAbs().maxCoeff(), 140 - 1e-9);
        EXPECT_EQ(p.z(), 20);
        EXPECT_TRUE(std::isnan(time));
        break;
      case Contact::free:
        ADD_FAILURE() << "nothing stays in the air";
    }
  }
  EXPECT_GT(on_mold, 400);
  EXPECT_GT(on_platform, 1500);
  EXPECT_TRUE(formed->summary.converged);
  EXPECT_EQ(formed->summary.pressure_kpa, 0);
  EXPECT_TRUE(std::isnan(formed->summary.residual));
  EXPECT_TRUE(std::isnan(formed->summary.force_error));
  EXPECT_LT(formed->summary.mass_error, 1e-6);
}

TEST(Projection, CanBeCancelled) {
  FormingSettings settings;
  settings.model = FormingModel::projection;
  Context context;
  context.cancel();
  const auto formed = form(hemisphere(60), {}, {}, settings, TemperatureField(140), context);
  ASSERT_FALSE(formed);
  EXPECT_EQ(formed.error().code, Code::cancelled);
}

}  // namespace
}  // namespace vacuform::projection_test
