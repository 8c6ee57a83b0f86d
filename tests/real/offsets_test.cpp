#include "tests/unit/fixtures/offset_sweep.hpp"

#include "tests/real/real_scans.hpp"

namespace vacuform::offsets_test {
namespace {

TEST(RealScans, OffsetsAreAsLongAsAsked) {
  for (const char* file : {"neonate-40w.stl", "adult-scalp-ascii.ply", "child-headform-metres.stl",
                           "adult-fsaverage-metres.obj"}) {
    VACUFORM_READ_REAL_SCAN(scan, file);
    offset_sweep::expect_offsets(scan, file, {FlatteningMethod::arap, FlatteningMethod::lscm},
                                 {{20, 0}, {0, 30}, {-48, -36}});
  }
}

}  // namespace
}  // namespace vacuform::offsets_test
