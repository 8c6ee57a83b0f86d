#include "worker/coils/metric_mds.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace vacuform {

namespace {

using Eigen::Vector2d;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Shifted and turned onto `to`, by rigid least squares.
void lay_on(const std::vector<Vector2d>& to, std::vector<Vector2d>& places) {
  Vector2d from_middle(0, 0), to_middle(0, 0);
  const double n = static_cast<double>(to.size());
  for (std::size_t i = 0; i < to.size(); ++i) from_middle += places[i] / n, to_middle += to[i] / n;
  double c = 0, s = 0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const Vector2d x = places[i] - from_middle, y = to[i] - to_middle;
    c += x.dot(y);
    s += x.x() * y.y() - x.y() * y.x();
  }
  const Eigen::Rotation2Dd turn(std::atan2(s, c));
  for (Vector2d& p : places) p = turn * (p - from_middle) + to_middle;
}

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
      Vector2d to(0, 0);  // the mean of where each neighbour would have it
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
  lay_on(start, places);
  return places;
}

}  // namespace vacuform
