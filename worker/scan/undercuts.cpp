#include "worker/scan/undercuts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/scan/ray_caster.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

constexpr double least_height_mm = 0.2;
constexpr double least_depth_mm = 1.0;

struct Span {  // empty space under a ceiling
  int column;
  double low, high;
};

class Columns {
 public:
  Columns(const TriangleMesh& mesh, double floor, double spacing) : mesh_(mesh), floor_(floor), spacing_(spacing) {
    const Box box = bounds(mesh);
    // A ring of empty columns around, so that every depth has an open column to be measured from.
    origin_ = {box.low.x() - 1.5 * spacing, box.low.y() - 1.5 * spacing};
    nx = static_cast<int>(std::ceil(box.size().x() / spacing)) + 3;
    ny = static_cast<int>(std::ceil(box.size().y() / spacing)) + 3;
    ceiling_ = box.high.z() + 1;
    top.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny), -HUGE_VAL);
  }

  Eigen::Vector2d place(int column) const {
    return {origin_.x() + (column % nx + 0.5) * spacing_, origin_.y() + (column / nx + 0.5) * spacing_};
  }

  Result<void> cast(const Context& context) {
    const RayCaster caster(mesh_);
    const double step = 1e-5 * bounds(mesh_).size().norm();  // beyond the rays' own error
    for (int column = 0; column < nx * ny; ++column) {
      if (column % (16 * nx) == 0) VACUFORM_CHECK(context.step(Stage::scan, 0.6));
      const Eigen::Vector2d xy = place(column);
      double z = ceiling_, opened = 0;
      int depth = 0, last = -1;
      bool met = false;
      while (z > floor_) {
        const double reach = z - floor_ + 1;
        const auto hit = caster.first_hit({xy.x(), xy.y(), z}, {0, 0, -reach});
        if (!hit) break;
        const double at = z - hit->t * reach;
        z = at - step;
        if (hit->triangle == last) continue;
        last = hit->triangle;
        const double up = area_vector(mesh_, mesh_.triangles[static_cast<std::size_t>(hit->triangle)]).z();
        if (up > 0) {
          if (depth++ == 0) {
            if (!met) top[static_cast<std::size_t>(column)] = at;
            if (met && opened - at > least_height_mm) spans.push_back({column, at, opened});
            met = true;
          }
        } else if (up < 0 && depth > 0 && --depth == 0) {
          opened = at;
        }
      }
      if (met && depth == 0 && opened - floor_ > least_height_mm) spans.push_back({column, floor_, opened});
    }
    return {};
  }

  // Horizontal distance from the column to the nearest one whose top lies below z.
  double distance_to_open(int column, double z) const {
    const int cx = column % nx, cy = column / nx;
    double best = HUGE_VAL;
    const auto look = [&](int x, int y) {
      if (x < 0 || y < 0 || x >= nx || y >= ny) return;
      if (top[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x)] >= z) return;
      best = std::min(best, std::hypot(x - cx, y - cy));
    };
    for (int r = 1; r <= std::max(nx, ny) && r < best; ++r) {
      for (int d = -r; d <= r; ++d) look(cx + d, cy - r), look(cx + d, cy + r);
      for (int d = -r + 1; d < r; ++d) look(cx - r, cy + d), look(cx + r, cy + d);
    }
    return std::max(0.0, best - 0.5) * spacing_;
  }

  int nx = 0, ny = 0;
  std::vector<double> top;  // of each column; -inf where nothing stands
  std::vector<Span> spans;  // by column, from above

 private:
  const TriangleMesh& mesh_;
  double floor_, spacing_, ceiling_ = 0;
  Eigen::Vector2d origin_;
};

// Spans of neighbouring columns that overlap in height belong together.
std::vector<int> cluster(const Columns& columns) {
  const auto& spans = columns.spans;
  std::vector<int> parent(spans.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      auto& p = parent[static_cast<std::size_t>(i)];
      i = p = parent[static_cast<std::size_t>(p)];
    }
    return i;
  };
  std::vector<int> first(columns.top.size() + 1, 0);  // span of each column
  for (const auto& span : spans) ++first[static_cast<std::size_t>(span.column) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  for (int i = 0; i < static_cast<int>(spans.size()); ++i) {
    const auto& a = spans[static_cast<std::size_t>(i)];
    for (const int neighbour : {a.column + 1, a.column + columns.nx})  // the outer ring holds no spans: no wrapping
      for (int j = first[static_cast<std::size_t>(neighbour)]; j < first[static_cast<std::size_t>(neighbour) + 1]; ++j) {
        const auto& b = spans[static_cast<std::size_t>(j)];
        if (a.low <= b.high && b.low <= a.high) parent[static_cast<std::size_t>(root(j))] = root(i);
      }
  }
  std::vector<int> of(spans.size());
  for (int i = 0; i < static_cast<int>(spans.size()); ++i) of[static_cast<std::size_t>(i)] = root(i);
  return of;
}

}  // namespace

Result<std::vector<Pocket>> find_pockets(const TriangleMesh& mesh, double floor, double spacing, const Context& context) {
  Columns columns(mesh, floor, spacing);
  VACUFORM_CHECK(columns.cast(context));
  const auto cluster_of = cluster(columns);

  std::vector<int> number(columns.spans.size(), -1), last_column;
  std::vector<Pocket> pockets;
  for (std::size_t i = 0; i < columns.spans.size(); ++i) {
    if (i % 4096 == 0) VACUFORM_CHECK(context.step(Stage::scan, 0.7));
    const auto& span = columns.spans[i];
    int& n = number[static_cast<std::size_t>(cluster_of[i])];
    if (n < 0) {
      n = static_cast<int>(pockets.size());
      pockets.push_back({{Eigen::Vector3d::Zero(), -1, 0}, -HUGE_VAL});
      last_column.push_back(-1);
    }
    auto& pocket = pockets[static_cast<std::size_t>(n)];
    const double depth = columns.distance_to_open(span.column, span.low + least_height_mm / 2);
    if (depth > pocket.undercut.depth_mm) {
      const Eigen::Vector2d xy = columns.place(span.column);
      pocket.undercut.place = {xy.x(), xy.y(), span.low};
      pocket.undercut.depth_mm = depth;
    }
    if (last_column[static_cast<std::size_t>(n)] != span.column) pocket.undercut.area_mm2 += spacing * spacing;
    last_column[static_cast<std::size_t>(n)] = span.column;
    pocket.begins = std::max(pocket.begins, span.high);
  }
  std::stable_sort(pockets.begin(), pockets.end(), [](const Pocket& a, const Pocket& b) {
    if (a.undercut.depth_mm != b.undercut.depth_mm) return a.undercut.depth_mm > b.undercut.depth_mm;
    return a.undercut.area_mm2 > b.undercut.area_mm2;
  });
  return pockets;
}

double undercuts_begin(const std::vector<Pocket>& pockets, double floor, double least_area) {
  double begins = floor;
  for (const auto& pocket : pockets)
    if (pocket.undercut.depth_mm >= least_depth_mm && pocket.undercut.area_mm2 >= least_area)
      begins = std::max(begins, pocket.begins);
  return begins;
}

}  // namespace vacuform
