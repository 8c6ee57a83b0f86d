#include "worker/scan/rebuilding.hpp"

#include "worker/scan/topology.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform {
namespace {

constexpr double offset_mm = 0.1;
constexpr double plate_depth_mm = 0.5;
constexpr double kept_volume = 0.7;       // of what the widest bridging encloses
constexpr int most_fine_steps = 150'000;  // a head's outside takes 105,000 at the narrowest

// For all wraps together; 5 s for a scan of 1 MiB. Heads of 4,000, 8,500 and 27,000 loose triangles need 20, 28 and 48
// million.
std::int64_t most_tests(const TriangleMesh& skin) {
  return 25'000'000 + 1000 * static_cast<std::int64_t>(skin.triangles.size());
}

// A plate a little below the platform, as wide as the scan: the cut at the platform removes it again.
TriangleMesh with_plate(TriangleMesh skin) {
  const Box box = bounds(skin);
  const int first = static_cast<int>(skin.vertices.size());
  skin.vertices.emplace_back(box.low.x(), box.low.y(), -plate_depth_mm);
  skin.vertices.emplace_back(box.high.x(), box.low.y(), -plate_depth_mm);
  skin.vertices.emplace_back(box.high.x(), box.high.y(), -plate_depth_mm);
  skin.vertices.emplace_back(box.low.x(), box.high.y(), -plate_depth_mm);
  skin.triangles.push_back({first, first + 1, first + 2});
  skin.triangles.push_back({first, first + 2, first + 3});
  return skin;
}

}  // namespace

// A wide bridging finds the volume that the scan encloses, and whether it is open below. Then the narrowest bridging
// that keeps the volume is used: one that is too narrow slips through the gaps of the scan and also wraps its inside. A
// wrap of both sides, in and out of every crevice, costs many times as much as one of the outside alone. So the search
// goes from wide to narrow and stops at a bridging that slips through, or whose wrap costs more than any outside. It
// also stops if a wrap costs too much because long thin triangles meet: the narrowest wrap within the budget is used.
Result<TriangleMesh> rebuild(const TriangleMesh& skin, const ScanProgress& progress) {
  const double size = bounds(skin).size().norm();
  WrapBudget budget{most_tests(skin)};
  VACUFORM_TRY(coarse, wrap(skin, 0.15 * size, offset_mm, progress, budget));
  const TriangleMesh plated = with_plate(skin);
  VACUFORM_TRY(coarse_plated, wrap(plated, 0.15 * size, offset_mm, progress, budget));
  const bool open_below = signed_volume(coarse) < kept_volume * signed_volume(coarse_plated);
  if (open_below) coarse = std::move(coarse_plated);
  const double least_volume = kept_volume * signed_volume(coarse);
  budget.steps = most_fine_steps;
  for (const double share : {0.075, 0.03, 0.012}) {
    auto fine = wrap(open_below ? plated : skin, share * size, offset_mm, progress, budget);
    if (!fine && fine.error().code == Code::cancelled) return fine;
    if (!fine || signed_volume(*fine) <= least_volume) break;
    coarse = std::move(*fine);
  }
  return coarse;
}

}  // namespace vacuform
