#include "worker/inspection/unfolded_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

void add_moves(const Finished& job, Unfolded& out) {
  if (!job.placed || job.placement.elements.empty()) return;
  const PlaneLocator chart(job.sheet.triangles, job.sheet.rest, job.flattening.triangles);
  struct Move {
    Eigen::Vector3d centre;
    Vector2d by;
    double radius_mm;
  };
  std::vector<Move> moves;
  for (const PlacedElement& placed : job.placement.elements) {
    const Element& element = job.placed->elements[index(placed.element)];
    if (const auto at = element.loop ? chart.find(placed.centre_rest) : std::nullopt)
      moves.push_back({placed.centre, element.centre - interpolate(job.sheet.triangles, *at, out.uv),
                       placed.size * std::sqrt(element.loop->area_mm2 / M_PI)});
  }
  for (std::size_t i = 0; i < out.uv.size(); ++i) {
    if (out.uv[i].hasNaN()) continue;
    const Eigen::Vector3d& place = job.surface.inked()[index(out.vertex[i])];
    Vector2d sum(0, 0);
    double weights = 1;  // of no move
    for (const Move& move : moves) {
      const double ratio =
          move.radius_mm * move.radius_mm / std::max(1e-3, (place - move.centre).squaredNorm());
      sum += ratio * ratio * move.by, weights += ratio * ratio;
    }
    out.uv[i] += sum / weights;
  }
}

}  // namespace

Unfolded unfolded(const Finished& job) {
  const std::size_t count = job.sheet.formed.size();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Unfolded out{std::vector<int>(count), std::vector<Vector2d>(count, Vector2d(nan, nan)),
               job.sheet.triangles};
  std::iota(out.vertex.begin(), out.vertex.end(), 0);
  std::vector<std::vector<int>> more(count);  // further copies of each vertex
  for (std::size_t i = 0; i < job.flattening.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      int& v = out.corners[job.flattening.triangles[i]][k];
      const auto first = static_cast<std::size_t>(v);
      const Vector2d& uv = job.print.pattern_uv[i][k];
      const auto is_it = [&](int copy) { return out.uv[copy] == uv; };
      if (out.uv[first].hasNaN()) out.uv[first] = uv;
      if (is_it(v)) continue;
      auto copy = std::find_if(more[first].begin(), more[first].end(), is_it);
      if (copy == more[first].end()) {
        copy = more[first].insert(copy, static_cast<int>(out.vertex.size()));
        out.vertex.push_back(v);
        out.uv.push_back(uv);
      }
      v = *copy;
    }
  return out;
}

Unfolded textured(const Finished& job) {
  Unfolded out = unfolded(job);
  add_moves(job, out);
  return out;
}

}  // namespace vacuform
