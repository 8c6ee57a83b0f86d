#include "worker/placement/chart_pieces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <queue>
#include <tuple>

#include "worker/stage/index.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

// The nearest of the seeds to each triangle of `faces` by way of its neighbours among them, and how far it is.
struct Nearest {
  std::vector<int> seed;  // over the region; -1 elsewhere
  std::vector<double> mm;
};
Nearest nearest_seed(const Region& region, const Faces& faces, const std::vector<int>& seeds) {
  Nearest out{std::vector<int>(region.area.size(), -1), std::vector<double>(region.area.size(), -1)};
  for (const int t : faces) out.mm[index(t)] = std::numeric_limits<double>::infinity();
  using Entry = std::tuple<double, int, int>;  // distance, triangle, seed
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t s = 0; s < seeds.size(); ++s) queue.emplace(0, seeds[s], static_cast<int>(s));
  while (!queue.empty()) {
    const auto [mm, t, seed] = queue.top();
    queue.pop();
    if (out.seed[index(t)] >= 0) continue;
    out.seed[index(t)] = seed;
    out.mm[index(t)] = mm;
    for (const int n : region.across[index(t)])
      if (n >= 0 && out.seed[index(n)] < 0 && out.mm[index(n)] >= 0)
        queue.emplace(mm + (region.middle[index(n)] - region.middle[index(t)]).norm(), n, seed);
  }
  return out;
}

// A triangle with two neighbours in the other part joins it, so that seams have no teeth.
void smooth(const Region& region, const Faces& faces, std::vector<int>& part) {
  for (int round = 0; round < 4; ++round)
    for (const int t : faces) {
      int others = 0, own = 0;
      for (const int n : region.across[index(t)]) {
        if (n < 0 || part[index(n)] < 0) continue;
        ++(part[index(n)] == part[index(t)] ? own : others);
      }
      if (others == 2 && own == 1) part[index(t)] = 1 - part[index(t)];
    }
}

}  // namespace

Region::Region(const Patch& of, const std::vector<Edge>& cuts)
    : chart(of), beside(of.triangles.size(), {-1, -1, -1}), across(beside) {
  const std::vector<int> opposite = opposite_sides(chart.triangles);
  for (std::size_t t = 0; t < chart.triangles.size(); ++t) {
    const Triangle& c = chart.triangles[t];
    const Vector3d &p = chart.inked[index(c[0])], &q = chart.inked[index(c[1])],
                   &r = chart.inked[index(c[2])];
    middle.push_back((p + q + r) / 3);
    area.push_back((q - p).cross(r - p).norm() / 2);
    for (std::size_t e = 0; e < 3; ++e) {
      const int side = opposite[3 * t + (e + 2) % 3];
      if (side < 0) continue;
      beside[t][e] = side / 3;
      const Edge edge = std::minmax(c[e], c[(e + 1) % 3]);
      if (!std::binary_search(cuts.begin(), cuts.end(), edge)) across[t][e] = side / 3;
    }
  }
}

std::vector<Faces> connected(const Region& region, const Faces& faces) {
  std::vector<char> inside(region.area.size(), 0);
  for (const int t : faces) inside[index(t)] = 1;
  std::vector<Faces> out;
  for (const int first : faces) {
    if (!inside[index(first)]) continue;
    Faces piece{first};
    inside[index(first)] = 0;
    for (std::size_t i = 0; i < piece.size(); ++i)
      for (const int n : region.across[index(piece[i])])
        if (n >= 0 && inside[index(n)]) inside[index(n)] = 0, piece.push_back(n);
    std::sort(piece.begin(), piece.end());
    out.push_back(std::move(piece));
  }
  return out;
}

std::vector<Faces> halves(const Region& region, const Faces& faces) {
  const auto farthest = [&](int from) {
    const Nearest way = nearest_seed(region, faces, {from});
    return *std::max_element(faces.begin(), faces.end(),
                             [&](int a, int b) { return way.mm[index(a)] < way.mm[index(b)]; });
  };
  std::vector<int> seeds{farthest(faces.front())};
  seeds.push_back(farthest(seeds.front()));
  std::vector<int> part;
  for (int round = 0; round < 6; ++round) {
    part = nearest_seed(region, faces, seeds).seed;
    for (int side = 0; side < 2; ++side) {
      Vector3d sum = Vector3d::Zero();
      double total = 0;
      for (const int t : faces)
        if (part[index(t)] == side)
          sum += region.area[index(t)] * region.middle[index(t)], total += region.area[index(t)];
      double best = std::numeric_limits<double>::infinity();
      for (const int t : faces)
        if (const double d = (region.middle[index(t)] - sum / total).norm();
            part[index(t)] == side && d < best)
          best = d, seeds[index(side)] = t;
    }
  }
  smooth(region, faces, part);
  std::vector<Faces> out;
  for (int side = 0; side < 2; ++side) {
    Faces half;
    for (const int t : faces)
      if (part[index(t)] == side) half.push_back(t);
    for (Faces& piece : connected(region, half)) out.push_back(std::move(piece));
  }
  return out;
}

Patch part_of(const Region& region, const Faces& faces) {
  Patch out;
  out.triangles.assign(faces.size(), {-1, -1, -1});
  std::vector<int> row(region.area.size(), -1);
  for (std::size_t i = 0; i < faces.size(); ++i) row[index(faces[i])] = static_cast<int>(i);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      if (out.triangles[i][k] >= 0) continue;
      const int v = region.chart.triangles[index(faces[i])][k], local = static_cast<int>(out.uv.size());
      out.uv.push_back(region.chart.uv[index(v)]);
      out.rest.push_back(region.chart.rest[index(v)]);
      out.inked.push_back(region.chart.inked[index(v)]);
      // All triangles around v that are reached without crossing a cut.
      std::vector<int> around{faces[i]};
      for (std::size_t a = 0; a < around.size(); ++a) {
        const int t = around[a];
        const Triangle& corners = region.chart.triangles[index(t)];
        const auto at =
            static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
        int& number = out.triangles[index(row[index(t)])][at];
        if (number >= 0) continue;
        number = local;
        for (const std::size_t e : {at, (at + 2) % 3})
          if (const int n = region.across[index(t)][e]; n >= 0 && row[index(n)] >= 0) around.push_back(n);
      }
    }
  return out;
}

}  // namespace vacuform
