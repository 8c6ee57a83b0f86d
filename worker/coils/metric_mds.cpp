#include "worker/coils/metric_mds.hpp"

#include "worker/numerics/rigid_fit.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

}  // namespace

std::vector<Vector2d> metric_mds(const std::vector<Vector2d>& start, const std::vector<Neighbours>& pairs,
                                 const std::vector<double>& mm) {
  constexpr int most_sweeps = 2000;
  constexpr double settled_mm = 1e-5;
  std::vector<Vector2d> places = start;
  std::vector<std::vector<std::pair<int, double>>> around(start.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    around[index(pairs[p].a)].push_back({pairs[p].b, mm[p]});
    around[index(pairs[p].b)].push_back({pairs[p].a, mm[p]});
  }
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double moved = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (around[i].empty()) continue;
      Vector2d to(0, 0);  // the mean of the places that the neighbours require
      for (const auto& [other, far] : around[i]) {
        const Vector2d way = places[i] - places[index(other)];
        to += (places[index(other)] + far / std::max(way.norm(), 1e-9) * way) /
              static_cast<double>(around[i].size());
      }
      moved = std::max(moved, (to - places[i]).norm());
      places[i] = to;
    }
    if (moved < settled_mm) break;
  }
  RigidFit fit;
  for (std::size_t i = 0; i < start.size(); ++i) fit.add(places[i], start[i]);
  const Eigen::Isometry2d motion = fit.motion();
  for (Vector2d& p : places) p = motion * p;
  return places;
}

}  // namespace vacuform
