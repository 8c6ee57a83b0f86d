#include "worker/surface/adjacency.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace vacuform {

namespace {

struct Edge {
  int low, high, side;
};

// Sorted by their ends: the two sides of an edge follow each other.
std::vector<Edge> edges_of(const std::vector<Triangle>& triangles) {
  const auto each = [&](auto&& take) {
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = triangles[t][(k + 1) % 3], b = triangles[t][(k + 2) % 3];
        take(Edge{std::min(a, b), std::max(a, b), static_cast<int>(3 * t + k)});
      }
  };
  // First by the lower end, of which each has few edges.
  int last = -1;
  each([&](const Edge& edge) { last = std::max(last, edge.low); });
  std::vector<std::size_t> begin(static_cast<std::size_t>(last + 2), 0);
  each([&](const Edge& edge) { ++begin[static_cast<std::size_t>(edge.low) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Edge> edges(3 * triangles.size());
  std::vector<std::size_t> next(begin.begin(), begin.end());
  each([&](const Edge& edge) { edges[next[edge.low]++] = edge; });
  for (std::size_t v = 0; v + 1 < begin.size(); ++v)
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(begin[v]),
              edges.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]), [](const Edge& x, const Edge& y) {
                return std::tie(x.high, x.side) < std::tie(y.high, y.side);
              });
  return edges;
}

}  // namespace

std::vector<int> opposite_sides(const std::vector<Triangle>& triangles) {
  const std::vector<Edge> edges = edges_of(triangles);
  std::vector<int> opposite(3 * triangles.size(), -1);
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i != 2) continue;
    opposite[edges[i].side] = edges[i + 1].side;
    opposite[edges[i + 1].side] = edges[i].side;
  }
  return opposite;
}

std::vector<std::vector<int>> border_loops(const std::vector<Triangle>& triangles) {
  int vertices = 0;
  for (const Triangle& t : triangles) vertices = std::max({vertices, t[0] + 1, t[1] + 1, t[2] + 1});
  // Border edges are those without a twin. Edges are listed at their lower vertex, so that twins meet.
  std::vector<std::vector<std::pair<int, bool>>> edges(vertices);
  for (const Triangle& t : triangles)
    for (int e = 0; e < 3; ++e) {
      const int a = t[e], b = t[(e + 1) % 3];
      edges[std::min(a, b)].push_back({std::max(a, b), a < b});
    }
  std::vector<std::vector<int>> next(vertices);
  for (int v = 0; v < vertices; ++v)
    for (const auto& [to, upwards] : edges[v])
      if (std::count_if(edges[v].begin(), edges[v].end(),
                        [to = to](const auto& e) { return e.first == to; }) == 1)
        next[upwards ? v : to].push_back(upwards ? to : v);

  std::vector<std::vector<int>> loops;
  for (int v = 0; v < vertices; ++v)
    while (!next[v].empty()) {
      std::vector<int> loop;
      for (int at = v; !next[at].empty();) {
        loop.push_back(at);
        const int to = next[at].back();
        next[at].pop_back();
        at = to;
      }
      loops.push_back(std::move(loop));
    }
  return loops;
}

VertexFans::VertexFans(const std::vector<Triangle>& triangles, std::size_t vertices)
    : first_(vertices + 1, 0), corners_(6 * triangles.size()) {
  for (const Triangle& t : triangles)
    for (const int v : t) first_[static_cast<std::size_t>(v) + 1] += 2;
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t other = 1; other < 3; ++other)
        corners_[next[static_cast<std::size_t>(t[k])]++] = t[(k + other) % 3];
}

VertexTriangles::VertexTriangles(const std::vector<Triangle>& triangles, std::size_t vertices)
    : first_(vertices + 1, 0), of_vertex_(3 * triangles.size()) {
  for (const Triangle& t : triangles)
    for (const int v : t) ++first_[static_cast<std::size_t>(v) + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int v : triangles[t]) of_vertex_[next[static_cast<std::size_t>(v)]++] = static_cast<int>(t);
}

}  // namespace vacuform
