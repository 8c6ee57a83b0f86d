#include "tests/unit/worker/forming/both_integrators.hpp"

#include "tests/real/real_scans.hpp"

namespace vacuform::both_integrators_test {
namespace {

TEST(RealScans, BothIntegratorsFormTheSameNeonate) {
  VACUFORM_READ_REAL_SCAN(neonate, "neonate-40w.stl");
  const auto mold = make_mold(neonate, "neonate-40w.stl", {}, Context{});
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_LT(apart(*mold, head_machine()), 0.1);
}

}  // namespace
}  // namespace vacuform::both_integrators_test
