#include "worker/conductors/widened.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/conductors/array_build.hpp"

namespace vacuform {
namespace {

using namespace hand_made;

TEST(InkRatio, IsReadBetweenTheRows) {
  const std::vector<std::array<double, 2>> rows{{1, 1}, {1.2, 1.5}, {1.4, 3}};
  EXPECT_EQ(ink_ratio({}, 1.3), 1);
  EXPECT_EQ(ink_ratio(rows, 0.9), 1);
  EXPECT_DOUBLE_EQ(ink_ratio(rows, 1.1), 1.25);
  EXPECT_DOUBLE_EQ(ink_ratio(rows, 1.3), 2.25);
  EXPECT_EQ(ink_ratio(rows, 2), 3);
}

// A plane sheet that is stretched by 2 across x > 0: the trace of a loop crosses it twice.
struct Stretched {
  DrawnLoop loop;
  Patch patch;
  Stretched() {
    for (int i = 0; i < 360; ++i) {
      const double angle = 2 * M_PI * i / 360;
      loop.line.emplace_back(20 * std::cos(angle), 20 * std::sin(angle));
    }
    loop.width_mm = 2;
    constexpr int side = 61;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double u = x - 30.0, v = y - 30.0;
        patch.uv.emplace_back(u, v);
        patch.rest.emplace_back(u > 0 ? u / 2 : u, v);
        patch.inked.emplace_back(u, v, 0);
        if (x > 0 && y > 0) {
          const int c = y * side + x;
          patch.triangles.push_back({c - side - 1, c - side, c});
          patch.triangles.push_back({c - side - 1, c, c - 1});
        }
      }
  }
};

TEST(Widened, FollowsTheRatioOfAreas) {
  const Stretched sheet;
  const Trace trace(sheet.loop, sheet.patch, 2, 1);
  const std::vector<double> loads = trace_loads(trace, {});
  const auto [least, most] = std::minmax_element(loads.begin(), loads.end());
  EXPECT_NEAR(*least, 1, 1e-6);
  EXPECT_NEAR(*most, 2, 1e-6);
  const WidenedTrace wide = widened(trace, loads, 1, {});
  EXPECT_NEAR(wide.widest, 2, 1e-6);
  EXPECT_NEAR(wide.mean, std::sqrt(2), 0.01);
  // All of it has the resistance of the unstretched part: less than an even trace of its mean width.
  EXPECT_NEAR(wide.resistance, std::sqrt(2) / 1.5, 0.01);
  double ink = 0;
  for (const Shape& shape : wide.added) ink += square_mm(fill_area(shape.curves, false, 0.01));
  EXPECT_NEAR(ink, M_PI * 20 * 4, 15);  // half of the loop, twice as wide, with 3 mm more at each end
}

TEST(Widened, IsLimitedAndKeepsWhatItIsTold) {
  const Stretched sheet;
  const Trace trace(sheet.loop, sheet.patch, 2, 1);
  const std::vector<double> loads = trace_loads(trace, {});
  EXPECT_EQ(widened(trace, loads, 0.1, {}).widest, WidenedTrace::most);
  EXPECT_EQ(widened(trace, loads, 0.1, {}).added.size(), 1u);  // all the way round
  const double length = trace.path().length();
  const WidenedTrace none = widened(trace, loads, 1, {{-length / 2, length / 2}});
  EXPECT_EQ(none.widest, 1);
  EXPECT_TRUE(none.added.empty());
  EXPECT_DOUBLE_EQ(none.resistance, 1);
}

// On a sheet that is drawn over a dome no millimetre of a trace has more resistance than another.
TEST(Widened, EvensTheResistanceOfAnArray) {
  const Sample sample = sphere(90, 440, 140);
  const Charted surface{sample};
  const Drawing drawing = seven_rings(30, 1.7 * 30);
  Settings settings;
  settings.print.compensate_width = true;
  const auto placement = place(surface, &drawing, settings, Context());
  const auto build = build_array(drawing, *placement, {surface, surface}, std::nullopt, settings, Context());
  ASSERT_TRUE(build);
  ASSERT_EQ(build->widened.size(), drawing.elements.size());
  double widest = 1;
  for (const WidenedTrace& each : build->widened) {
    EXPECT_LE(each.resistance, 1 + 1e-9);
    EXPECT_LE(each.mean, each.widest);
    widest = std::max(widest, each.widest);
  }
  EXPECT_GT(widest, 1.02);
}

}  // namespace
}  // namespace vacuform
