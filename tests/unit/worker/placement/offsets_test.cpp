// Offsets on the bundled heads, as formed and flattened.
#include "tests/unit/fixtures/offset_sweep.hpp"
#include "worker/sample/sample.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform {
namespace {

TEST(Offsets, AreAsLongAsAskedOnTheBundledHeads) {
  offset_sweep::expect_offsets(stl_bytes(sample_head(HeadForm::newborn)), "newborn.stl",
                               {FlatteningMethod::arap, FlatteningMethod::symmetric_dirichlet,
                                FlatteningMethod::lscm, FlatteningMethod::cgal_arap, FlatteningMethod::bfs},
                               {{20, 0}, {0, -30}, {-36, 48}});
  offset_sweep::expect_offsets(stl_bytes(sample_head(HeadForm::adult)), "adult.stl", {FlatteningMethod::arap},
                               {{40, 0}, {-17, -41}});
}

}  // namespace
}  // namespace vacuform
