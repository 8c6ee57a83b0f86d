// Arrays that are laid out for real heads at default settings: on the head, and weakly coupled also once printed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/real/real_scans.hpp"
#include "worker/coils/array_layout.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"

namespace vacuform::layouts_test {
namespace {

struct Case {
  const char* head;
  int count;
  double k_rms, k_neighbours, k, covered;  // at most these, and at least this share of the head
};
class RealLayouts : public testing::TestWithParam<Case> {};

TEST_P(RealLayouts, CoupleLittleOnTheHeadAndOnThePrint) {
  VACUFORM_READ_REAL_SCAN(scan, GetParam().head);
  Settings settings;
  const auto mold = make_mold(scan, GetParam().head, settings.scan, Context{});
  ASSERT_TRUE(mold) << mold.error().text();
  const auto sheet =
      form(*mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), Context{});
  ASSERT_TRUE(sheet) << sheet.error().text();
  const InkedSurface surface = inked_surface(*sheet, settings.pattern.inked_face);
  const auto flattening = flatten(*sheet, surface, *mold, settings.flattening, Context{});
  ASSERT_TRUE(flattening) << flattening.error().text();
  const ChartedSurface charted(surface, *flattening);
  settings.layout.count = GetParam().count;
  const auto array = lay_out_array(charted, settings.layout, settings.coils, Context{});
  ASSERT_TRUE(array) << array.error().text();
  EXPECT_EQ(array->off_head, 0);
  EXPECT_LT(array->k_rms, GetParam().k_rms);
  EXPECT_GT(array->covered, GetParam().covered);
  // Both sides of the head have as many: loops would slide to where it is flat.
  double right = 0;
  for (const Eigen::Vector3d& centre : array->centres)
    right += centre.x() / static_cast<double>(array->centres.size());
  const auto top = std::max_element(surface.inked().begin(), surface.inked().end(),
                                    [](const auto& a, const auto& b) { return a.z() < b.z(); });
  EXPECT_NEAR(right, top->x(), 12);
  ASSERT_TRUE(array->strongest && array->strongest_neighbours);
  EXPECT_LT(std::abs(array->strongest->k), GetParam().k);
  EXPECT_LT(std::abs(array->strongest_neighbours->k), GetParam().k_neighbours);
  EXPECT_EQ(array->coupled.has_value(), GetParam().k_neighbours > 0.01);

  // Printed, its loops lie where the layout has them, and couple as there.
  auto placed = place(charted, &array->drawing, settings, Context{});
  ASSERT_TRUE(placed) << placed.error().text();
  ASSERT_TRUE(add_couplings(charted, array->drawing, settings, Context{}, *placed));
  EXPECT_TRUE(placed->warnings.empty());
  ASSERT_EQ(placed->elements.size(), array->centres.size());
  for (std::size_t i = 0; i < array->centres.size(); ++i)
    EXPECT_LT((placed->elements[i].centre - array->centres[i]).norm(), 0.02) << i;
  const auto pairs = coupled_loops(*placed, array->drawing, Context()).value();
  for (const CoupledLoops& pair : pairs)
    EXPECT_LT(std::abs(pair.k), pair.overlap ? GetParam().k_neighbours : GetParam().k)
        << pair.a << " and " << pair.b;
}

INSTANTIATE_TEST_SUITE_P(Heads, RealLayouts,
                         testing::Values(Case{"adult-scalp-ascii.ply", 16, 0.0115, 0.01, 0.03, 0.35},
                                         Case{"adult-scalp-ascii.ply", 64, 0.01, 0.03, 0.065, 0.6},
                                         Case{"neonate-40w.stl", 24, 0.012, 0.01, 0.03, 0.5}));

}  // namespace
}  // namespace vacuform::layouts_test
