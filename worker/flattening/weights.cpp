#include "worker/flattening/weights.hpp"
#include "worker/surface/adjacency.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace vacuform {

namespace {

// The distance of corner c when a wave has reached a and b: straight from its source in the plane of the triangle if
// the source is visible through the edge a b, otherwise along an edge.
double through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double at_a,
               double at_b) {
  const FlatTriangle f = flat_triangle(a, b, c);
  const double along_edges = std::min(at_a + (c - a).norm(), at_b + (c - b).norm());
  if (!(f.length > 0)) return along_edges;
  const double x = (at_a * at_a - at_b * at_b + f.length * f.length) / (2 * f.length);
  const double squared = at_a * at_a - x * x;
  if (squared < 0) return along_edges;
  const double y = -std::sqrt(squared);
  const double crossing = f.height - y > 0 ? x + (f.along - x) * -y / (f.height - y) : x;
  if (crossing < 0 || crossing > f.length) return along_edges;
  return std::min(along_edges, std::hypot(f.along - x, f.height - y));
}

}  // namespace

std::vector<double> surface_distance(const Chart& chart, std::vector<double> distance) {
  const VertexFans fans(chart.triangles, distance.size());
  using Front = std::pair<double, int>;  // a distance and its vertex
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
  for (int v = 0; v < static_cast<int>(distance.size()); ++v)
    if (std::isfinite(distance[v])) front.push({distance[v], v});
  std::vector<char> passed(distance.size(), 0);
  while (!front.empty()) {
    const int v = front.top().second;
    front.pop();
    if (passed[v]) continue;
    passed[v] = 1;
    const auto around = fans.around(v);
    for (std::size_t i = 0; i < around.size(); ++i) {
      const int c = around[i], other = around[i ^ 1];
      if (passed[c]) continue;
      const double found = passed[other] ? through(chart.inked[v], chart.inked[other], chart.inked[c],
                                                   distance[v], distance[other])
                                         : distance[v] + (chart.inked[c] - chart.inked[v]).norm();
      if (found < distance[c]) distance[c] = found, front.push({found, c});
    }
  }
  return distance;
}

std::vector<double> center_weights(const Chart& chart, int triangle, const Eigen::Vector3d& corners,
                                   double weight) {
  std::vector<double> rim(chart.uv.size(), std::numeric_limits<double>::infinity()), top = rim;
  for (const auto& loop : border_loops(chart.triangles))
    for (const int v : loop) rim[v] = 0;
  const Triangle& t = chart.triangles[triangle];
  const Eigen::Vector3d point =
      corners[0] * chart.inked[t[0]] + corners[1] * chart.inked[t[1]] + corners[2] * chart.inked[t[2]];
  for (const int v : t) top[v] = (chart.inked[v] - point).norm();
  rim = surface_distance(chart, std::move(rim));
  top = surface_distance(chart, std::move(top));

  std::vector<double> weights;
  weights.reserve(chart.triangles.size());
  for (const auto& [a, b, c] : chart.triangles) {
    const double from_rim = rim[a] + rim[b] + rim[c], from_top = top[a] + top[b] + top[c];
    const double x = from_rim > 0 ? from_rim / (from_rim + from_top) : 0;
    weights.push_back(1 + (weight - 1) * x * x * (3 - 2 * x));
  }
  return weights;
}

namespace {

// `full` is the coverage above which a triangle has the full weight. A wider disk would also favour triangles next to
// the ink: on the head of a newborn with nineteen rings that leaves the ink a gain of 3.8 instead of 4.3.
std::vector<double> weights_by(const Chart& chart, const InkCoverage& coverage, double weight, double full) {
  std::vector<double> weights;
  weights.reserve(chart.triangles.size());
  for (const auto& [a, b, c] : chart.triangles) {
    const Eigen::Vector2d &p = chart.uv[a], &q = chart.uv[b], &r = chart.uv[c];
    const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
    weights.push_back(1 + (weight - 1) * std::min(1.0, coverage((p + q + r) / 3, longest / 2) / full));
  }
  return weights;
}

}  // namespace

std::vector<double> painted_weights(const Chart& chart, const InkCoverage& paint, double weight) {
  return weights_by(chart, paint, weight, 1);
}

std::vector<double> ink_weights(const Chart& chart, const InkCoverage& ink, double weight) {
  return weights_by(chart, ink, weight, 0.25);
}

}  // namespace vacuform
