#include "worker/printing/seam_gap.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include "worker/printing/patch_map.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

// The ends of a seam's edge in the pattern, as a segment has them; in the order of the triangle given.
struct SideOf {
  const Segment& segment;
  std::size_t row;
  const Vector2d& uv(std::size_t corner) const {
    return segment.patch.uv[segment.patch.triangles[row][corner]];
  }
};

SideOf side_of(const Segment& segment, int triangle) {
  const auto at = std::lower_bound(segment.triangles.begin(), segment.triangles.end(), triangle);
  return {segment, static_cast<std::size_t>(at - segment.triangles.begin())};
}

}  // namespace

std::vector<double> seam_gaps(const Placement& placement) {
  constexpr int steps = 10;
  std::vector<std::unique_ptr<PatchMap>> maps;
  if (!placement.seams.empty())
    for (const Segment& chart : placement.charts) maps.push_back(std::make_unique<PatchMap>(chart.patch));
  std::vector<double> out;
  for (const Seam& seam : placement.seams) {
    const PatchMap &of_a = *maps[seam.a], &of_b = *maps[seam.b];
    out.push_back(0);
    for (const SeamEdge& edge : seam.edges) {
      const SideOf a = side_of(placement.charts[seam.a], edge.triangle),
                   b = side_of(placement.charts[seam.b], edge.beside);
      const auto next = [](int e) { return static_cast<std::size_t>((e + 1) % 3); };
      const auto here = [](int e) { return static_cast<std::size_t>(e); };
      // Seen from the other side an edge runs the other way.
      const Vector2d &a0 = a.uv(here(edge.edge)), &a1 = a.uv(next(edge.edge)),
                     &b0 = b.uv(next(edge.beside_edge)), &b1 = b.uv(here(edge.beside_edge));
      for (int i = 0; i <= steps; ++i) {
        const double f = static_cast<double>(i) / steps;
        const auto by_a = of_a.rest_at(a0 + f * (a1 - a0)), by_b = of_b.rest_at(b0 + f * (b1 - b0));
        out.back() = std::max(
            out.back(), by_a && by_b ? (*by_a - *by_b).norm() : std::numeric_limits<double>::infinity());
      }
    }
  }
  return out;
}

}  // namespace vacuform
