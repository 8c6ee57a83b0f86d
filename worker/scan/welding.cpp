#include "worker/scan/welding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

// An open-addressed table from grid cells to the chain of the vertices kept in them. Only looked up, never iterated, so
// its order does not affect results.
class CellTable {
 public:
  using Cell = std::array<std::int64_t, 3>;

  explicit CellTable(std::size_t entries) {
    std::size_t slots = 16;
    while (slots < 2 * entries) slots *= 2;
    cells_.resize(slots);
    heads_.assign(slots, -1);
  }
  // The head of the chain of `cell`; -1 when it is empty.
  int& head(const Cell& cell) {
    std::size_t slot = hash(cell) & (heads_.size() - 1);
    while (heads_[slot] >= 0 && cells_[slot] != cell) slot = (slot + 1) & (heads_.size() - 1);
    cells_[slot] = cell;
    return heads_[slot];
  }

 private:
  static std::size_t hash(const Cell& cell) {
    std::uint64_t h = 0;
    for (const auto c : cell) {
      h = (h ^ static_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15u;
      h ^= h >> 29;
    }
    return h;
  }
  std::vector<Cell> cells_;
  std::vector<int> heads_;
};

// For each vertex, the first vertex that equals it.
std::vector<int> join_equal(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<int> order(vertices.size()), first(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int i) {
    const auto& p = vertices[i];
    return std::make_tuple(p.x(), p.y(), p.z());
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const auto ka = key(a), kb = key(b);
    return ka < kb || (ka == kb && a < b);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

void join_near(const std::vector<Eigen::Vector3d>& vertices, double tolerance, std::vector<int>& stands_for) {
  const double cell_size = 8 * tolerance;
  const auto cell_of = [&](const Eigen::Vector3d& p) {
    return CellTable::Cell{static_cast<std::int64_t>(std::floor(p.x() / cell_size)),
                           static_cast<std::int64_t>(std::floor(p.y() / cell_size)),
                           static_cast<std::int64_t>(std::floor(p.z() / cell_size))};
  };
  std::size_t distinct = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) distinct += stands_for[i] == static_cast<int>(i);
  CellTable table(distinct);
  std::vector<int> chain(vertices.size(), -1);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stands_for[i] != static_cast<int>(i)) continue;
    const auto& p = vertices[i];
    const auto low = cell_of(p - Eigen::Vector3d::Constant(tolerance));
    const auto high = cell_of(p + Eigen::Vector3d::Constant(tolerance));
    int found = -1;
    for (auto x = low[0]; x <= high[0] && found < 0; ++x)
      for (auto y = low[1]; y <= high[1] && found < 0; ++y)
        for (auto z = low[2]; z <= high[2] && found < 0; ++z)
          for (int j = table.head({x, y, z}); j >= 0 && found < 0; j = chain[j])
            if ((vertices[j] - p).cwiseAbs().maxCoeff() <= tolerance) found = j;
    if (found >= 0) {
      stands_for[i] = found;
    } else {
      int& head = table.head(cell_of(p));
      chain[i] = head;
      head = static_cast<int>(i);
    }
  }
  for (auto& s : stands_for) s = stands_for[s];
}

void drop_repeated_triangles(std::vector<Triangle>& triangles) {
  std::vector<std::pair<Triangle, int>> sorted;
  sorted.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle t = triangles[i];
    std::sort(t.begin(), t.end());
    sorted.emplace_back(t, static_cast<int>(i));
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<char> drop(triangles.size(), 0);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto& t = sorted[i].first;
    const bool repeated = i > 0 && t == sorted[i - 1].first;
    drop[sorted[i].second] = repeated || t[0] == t[1] || t[1] == t[2];
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (!drop[i]) triangles[kept++] = triangles[i];
  triangles.resize(kept);
}

}  // namespace

Box middle_box(const TriangleMesh& mesh) {
  Box box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  if (mesh.vertices.empty()) return box;
  std::vector<double> values(mesh.vertices.size());
  const auto low = static_cast<std::ptrdiff_t>(values.size() / 50);
  const auto high = static_cast<std::ptrdiff_t>(values.size()) - 1 - low;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = mesh.vertices[i][axis];
    std::nth_element(values.begin(), values.begin() + low, values.end());
    box.low[axis] = values[low];
    std::nth_element(values.begin(), values.begin() + high, values.end());
    box.high[axis] = values[high];
  }
  return box;
}

double robust_size(const TriangleMesh& mesh) { return middle_box(mesh).size().norm(); }

void weld(TriangleMesh& mesh, double tolerance) {
  auto stands_for = join_equal(mesh.vertices);
  double largest = 0;
  for (const auto& p : mesh.vertices) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  // Cells smaller than the rounding of that coordinate could not be numbered.
  if (tolerance > 1e-17 * largest) join_near(mesh.vertices, tolerance, stands_for);
  for (auto& t : mesh.triangles)
    for (int& v : t) v = stands_for[v];
  drop_repeated_triangles(mesh.triangles);
  drop_unused_vertices(mesh);
}

}  // namespace vacuform
