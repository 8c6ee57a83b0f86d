#include "worker/inspection/segment_colours.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

namespace vacuform {

namespace {

// Pale, and distinguishable by lightness without colour vision.
const std::array<Rgb, 7> palette{Rgb(0.68f, 0.85f, 0.93f), Rgb(0.98f, 0.86f, 0.62f), Rgb(0.72f, 0.88f, 0.70f),
                                 Rgb(0.95f, 0.75f, 0.72f), Rgb(0.82f, 0.77f, 0.92f), Rgb(0.93f, 0.93f, 0.72f),
                                 Rgb(0.80f, 0.80f, 0.80f)};
const Rgb dark(0.15f, 0.13f, 0.25f);

// In their order, each segment gets the first colour that no earlier neighbour has.
std::vector<int> colours_of(const Placement& placement) {
  std::vector<std::set<int>> taken(placement.charts.size());
  std::vector<int> out;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    int colour = 0;
    while (taken[i].contains(colour)) ++colour;
    out.push_back(colour % static_cast<int>(palette.size()));
    for (const Seam& seam : placement.seams) {
      if (seam.a == static_cast<int>(i)) taken[seam.b].insert(out.back());
      if (seam.b == static_cast<int>(i)) taken[seam.a].insert(out.back());
    }
  }
  return out;
}

}  // namespace

SegmentColours::SegmentColours(const Finished& job) : faces_(job.sheet.triangles.size()) {
  const Placement& placement = job.placement;
  const auto of_sheet = [&](int t) -> std::size_t {
    return static_cast<std::size_t>(job.flattening.triangles[t]);
  };
  const std::vector<int> colour = colours_of(placement);
  for (std::size_t s = 0; s < placement.charts.size(); ++s)
    for (const int t : placement.charts[s].triangles) {
      Face& face = faces_[of_sheet(t)];
      face.colour = colour[s];
      const Triangle& c = job.sheet.triangles[of_sheet(t)];
      const auto at = [&](std::size_t k) { return job.sheet.formed[c[k % 3]]; };
      const double twice = (at(1) - at(0)).cross(at(2) - at(0)).norm();
      for (std::size_t k = 0; k < 3; ++k) face.height_mm[k] = twice / (at(k + 2) - at(k + 1)).norm();
    }
  // The edge e of a triangle runs from its corner e to the next: opposite to the one after that.
  for (const Seam& seam : placement.seams)
    for (const SeamEdge& edge : seam.edges) {
      faces_[of_sheet(edge.triangle)].seam[(edge.edge + 2) % 3] = true;
      faces_[of_sheet(edge.beside)].seam[(edge.beside_edge + 2) % 3] = true;
    }
}

std::optional<Rgb> SegmentColours::operator()(const Seen& seen) const {
  const Face& face = faces_[seen.triangle];
  if (face.colour < 0) return std::nullopt;
  const double half_mm = std::max(0.35, 0.8 * seen.spacing_mm);
  for (std::size_t k = 0; k < 3; ++k)
    if (face.seam[k] && seen.weights[k] * face.height_mm[k] < half_mm) return dark;
  return palette[face.colour];
}

}  // namespace vacuform
