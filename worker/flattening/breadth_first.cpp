#include <algorithm>

#include "worker/flattening/methods.hpp"

namespace vacuform {

namespace {

// Position of the third corner when the triangle is laid onto its first two: centred on the edge, whose length in the
// chart may differ from its true length.
Eigen::Vector2d unfolded(const Chart& chart, int a, int b, int c) {
  const FlatTriangle f = flat_triangle(chart.inked[a], chart.inked[b], chart.inked[c]);
  const Eigen::Vector2d edge = chart.uv[b] - chart.uv[a];
  const Eigen::Vector2d along = edge.norm() > 0 ? Eigen::Vector2d(edge.normalized()) : Eigen::Vector2d(1, 0);
  return (chart.uv[a] + chart.uv[b]) / 2 + (f.along - f.length / 2) * along +
         f.height * Eigen::Vector2d(-along.y(), along.x());
}

}  // namespace

Result<FlatteningOutcome> flatten_breadth_first(Chart& chart, int seed, const Context& context) {
  std::vector<char> placed(chart.uv.size(), 0);
  const auto& [a, b, c] = chart.triangles[seed];
  const FlatTriangle f = flat_triangle(chart.inked[a], chart.inked[b], chart.inked[c]);
  // The first edge keeps the direction of the start.
  const Eigen::Vector2d edge = chart.uv[b] - chart.uv[a];
  chart.uv[b] =
      chart.uv[a] + f.length * (edge.norm() > 0 ? Eigen::Vector2d(edge.normalized()) : Eigen::Vector2d(1, 0));
  chart.uv[c] = unfolded(chart, a, b, c);
  placed[a] = placed[b] = placed[c] = 1;

  FlatteningOutcome outcome{0, true};
  std::vector<Eigen::Vector2d> sum(chart.uv.size());
  std::vector<int> count(chart.uv.size(), 0), reached;
  do {
    VACUFORM_CHECK(context.step(Stage::flattening, 1 - 1 / (1 + 0.02 * outcome.iterations)));
    reached.clear();
    for (const Triangle& t : chart.triangles)
      for (int k = 0; k < 3; ++k) {
        const int third = t[k], first = t[(k + 1) % 3], second = t[(k + 2) % 3];
        if (placed[third] || !placed[first] || !placed[second]) continue;
        if (count[third]++ == 0) sum[third].setZero(), reached.push_back(third);
        sum[third] += unfolded(chart, first, second, third);
      }
    for (const int v : reached) chart.uv[v] = sum[v] / count[v], placed[v] = 1;
    ++outcome.iterations;
  } while (!reached.empty());
  return outcome;
}

}  // namespace vacuform
