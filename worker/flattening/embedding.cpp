#include "worker/flattening/embedding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "worker/flattening/chart_matrix.hpp"
#include "worker/numerics/supernodal_cholesky.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {

double side(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
}

struct Segment {
  Eigen::Vector2d from, to;
  int first, second;  // vertices
  double left() const { return std::min(from.x(), to.x()); }
  double right() const { return std::max(from.x(), to.x()); }
};

bool meet(const Segment& a, const Segment& b) {
  if (std::max(a.from.y(), a.to.y()) < std::min(b.from.y(), b.to.y()) ||
      std::max(b.from.y(), b.to.y()) < std::min(a.from.y(), a.to.y()))
    return false;
  if (a.first == b.second || a.second == b.first || a.first == b.first || a.second == b.second) return false;
  return side(a.from, a.to, b.from) * side(a.from, a.to, b.to) <= 0 &&
         side(b.from, b.to, a.from) * side(b.from, b.to, a.to) <= 0;
}

bool is_disk(const Chart& chart, const std::vector<std::vector<int>>& loops) {
  if (loops.size() != 1) return false;
  // Every edge has two triangles but the border's, which have one: V - E + F = 1.
  const auto edges = (3 * chart.triangles.size() + loops[0].size()) / 2;
  return chart.uv.size() + chart.triangles.size() == edges + 1;
}

}  // namespace

int border_crossings(const Chart& chart) {
  std::vector<Segment> segments;
  for (const auto& loop : border_loops(chart.triangles))
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const int a = loop[i], b = loop[(i + 1) % loop.size()];
      segments.push_back({chart.uv[a], chart.uv[b], a, b});
    }
  std::stable_sort(segments.begin(), segments.end(),
                   [](const Segment& a, const Segment& b) { return a.left() < b.left(); });
  int crossings = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::size_t j = i + 1; j < segments.size() && segments[j].left() <= segments[i].right(); ++j)
      crossings += meet(segments[i], segments[j]);
  return crossings;
}

bool embed_on_disk(Chart& chart) {
  const auto loops = border_loops(chart.triangles);
  if (!is_disk(chart, loops)) return false;
  double area = 0, length = 0;
  for (const ChartElement& e : elements(chart)) area += e.area;
  const auto& loop = loops[0];
  std::vector<double> reached;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    reached.push_back(length);
    length += std::max(1e-6, (chart.inked[loop[(i + 1) % loop.size()]] - chart.inked[loop[i]]).norm());
  }
  std::vector<char> fixed(chart.uv.size(), 0);
  const double radius = std::sqrt(area / std::numbers::pi);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const double angle = 2 * std::numbers::pi * reached[i] / length;
    chart.uv[loop[i]] = radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    fixed[loop[i]] = 1;
  }

  // Every other vertex in the middle of its neighbours.
  ChartMatrix<1> L(chart);
  L.reset(0);
  SupernodalCholesky::Columns<2> rhs = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(chart.uv.size()), 2);
  for (std::size_t k = 0; k < chart.triangles.size(); ++k) {
    const Triangle& t = chart.triangles[k];
    Eigen::Matrix3d local = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) {
      if (fixed[t[i]]) {
        local(i, i) = 1;
        rhs.row(t[i]) += chart.uv[t[i]].transpose();
        continue;
      }
      for (int j = 0; j < 3; ++j) {
        local(i, i) += j != i;
        if (j != i && fixed[t[j]]) rhs.row(t[i]) += chart.uv[t[j]].transpose();
        if (j != i && !fixed[t[j]]) local(i, j) = -1;
      }
    }
    L.add(k, local);
  }
  SupernodalCholesky cholesky(L.matrix());
  if (!cholesky.factor(L.matrix())) throw std::logic_error("Tutte's matrix is not positive definite");
  cholesky.solve(rhs);
  for (std::size_t i = 0; i < chart.uv.size(); ++i)
    if (!fixed[i]) chart.uv[i] = rhs.row(static_cast<Eigen::Index>(i));
  return true;
}

}  // namespace vacuform
