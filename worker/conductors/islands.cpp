#include "worker/conductors/islands.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/pattern/drawn_loop.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double row_mm = 0.5;
long row_of(double y) { return std::lround(std::floor(y / row_mm)); }

}  // namespace

Islands::Islands(const std::vector<Ring>& rings) {
  const Area area = union_of(rings);
  for (const Ring& ring : area)
    if (signed_area(ring) > 0) outlines_.push_back({ring});
  const auto add = [&](const Ring& ring, int island) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
      if (a.y() == b.y()) continue;
      const bool up = a.y() < b.y();
      const Edge edge{up ? a : b, up ? b : a, island, up ? 1 : -1};
      for (long row = row_of(edge.low.y()); row <= row_of(edge.high.y()); ++row) rows_[row].push_back(edge);
    }
  };
  for (std::size_t i = 0; i < outlines_.size(); ++i) add(outlines_[i].front(), static_cast<int>(i));
  // A hole lies in the island whose outline was found around it last: islands within holes come after it, around nothing
  // of it.
  for (const Ring& ring : area) {
    if (signed_area(ring) > 0) continue;
    const Vector2d& just_out = ring.front();
    int around = -1;
    double least = 0;
    for (std::size_t i = 0; i < outlines_.size(); ++i) {
      const Ring& outer = outlines_[i].front();
      const double size = signed_area(outer);
      if ((around < 0 || size < least) && size > -signed_area(ring) && is_inside(just_out, outer))
        around = static_cast<int>(i), least = size;
    }
    if (around < 0) continue;
    outlines_[index(around)].push_back(ring);
    add(ring, around);
  }
  for (auto& [row, edges] : rows_)
    std::stable_sort(edges.begin(), edges.end(),
                     [](const Edge& a, const Edge& b) { return a.island < b.island; });
}

int Islands::at(const Vector2d& p) const {
  const auto row = rows_.find(row_of(p.y()));
  if (row == rows_.end()) return -1;
  const std::vector<Edge>& edges = row->second;
  for (std::size_t i = 0; i < edges.size();) {
    const int island = edges[i].island;
    int winding = 0;
    for (; i < edges.size() && edges[i].island == island; ++i) {
      const Edge& e = edges[i];
      if (p.y() < e.low.y() || p.y() >= e.high.y()) continue;
      const double x = e.low.x() + (p.y() - e.low.y()) / (e.high.y() - e.low.y()) * (e.high.x() - e.low.x());
      if (x > p.x()) winding += e.winding;
    }
    if (winding != 0) return island;
  }
  return -1;
}

}  // namespace vacuform
