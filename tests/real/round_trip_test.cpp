#include "tests/unit/worker/printing/round_trip.hpp"

#include "tests/real/real_scans.hpp"

namespace vacuform::round_trip_test {
namespace {

TEST(RealScans, RingsOnTheNeonateComeOutRound) {
  VACUFORM_READ_REAL_SCAN(neonate, "neonate-40w.stl");
  round_trip::expect_round_rings(neonate, 48.4);  // the rings lie where the overlap was first measured
}

}  // namespace
}  // namespace vacuform::round_trip_test
