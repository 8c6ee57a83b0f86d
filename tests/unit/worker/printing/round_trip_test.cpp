#include "tests/unit/worker/printing/round_trip.hpp"

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform {
namespace {

// Half an ellipsoid with the breadth and length of a newborn's head. Unlike the crown of the sample, it has a continuous curvature.
TEST(RoundTrip, RingsOnAnEggOfANewbornsSizeComeOutRound) {
  TriangleMesh egg = hemisphere(1).mesh;
  for (auto& v : egg.vertices) v = v.cwiseProduct(Eigen::Vector3d(45, 63, 55));
  round_trip::expect_round_rings(stl_bytes(egg), 0);
}

}  // namespace
}  // namespace vacuform
