#include "worker/printing/patch_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

std::vector<Ring> border_in_pattern(const Patch& patch) {
  std::vector<Ring> rings;
  for (const auto& vertices : border_of(patch)) {
    rings.emplace_back();
    for (const int v : vertices) rings.back().push_back(patch.uv[static_cast<std::size_t>(v)]);
  }
  return rings;
}

}  // namespace

std::vector<std::vector<int>> border_of(const Patch& patch) {
  using Edge = std::pair<int, int>;
  std::vector<Edge> edges;
  edges.reserve(3 * patch.triangles.size());
  for (const Triangle& t : patch.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  std::multimap<int, int> next;
  for (const auto& [a, b] : edges)
    if (!std::binary_search(edges.begin(), edges.end(), Edge(b, a))) next.emplace(a, b);
  std::vector<std::vector<int>> rings;
  while (!next.empty()) {
    rings.emplace_back();
    for (auto at = next.begin(); at != next.end();) {
      rings.back().push_back(at->first);
      const int to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  return rings;
}

PatchMap::PatchMap(const Patch& patch) : patch_(patch), outline_(union_of(border_in_pattern(patch))) {
  for (const Ring& ring : outline_)
    for (const Vector2d& p : ring) border_.emplace_back(p.x(), p.y());
  std::sort(border_.begin(), border_.end());
  AlignedBox2d box;
  for (const Vector2d& uv : patch.uv)
    if (uv.allFinite()) box.extend(uv);
  if (box.isEmpty()) return;
  low_ = box.min();
  const Vector2d size = box.sizes().cwiseMax(1e-6);
  const double triangles = std::max<double>(1, static_cast<double>(patch.triangles.size()));
  cell_ = std::max(std::sqrt(size.prod() / triangles), size.maxCoeff() / 2000);
  columns_ = static_cast<int>(size.x() / cell_) + 1;
  rows_ = static_cast<int>(size.y() / cell_) + 1;

  const auto cells_of = [&](const Triangle& t) {
    AlignedBox2d around;
    for (const int v : t) around.extend(patch.uv[static_cast<std::size_t>(v)]);
    const auto index = [&](double x, int limit) {
      return std::clamp(static_cast<int>(x / cell_), 0, limit - 1);
    };
    return std::array<int, 4>{
        index(around.min().x() - low_.x(), columns_), index(around.min().y() - low_.y(), rows_),
        index(around.max().x() - low_.x(), columns_), index(around.max().y() - low_.y(), rows_)};
  };
  first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const bool counting : {true, false}) {
    std::vector<int> fill(first_);
    for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
      const auto [x0, y0, x1, y1] = cells_of(patch.triangles[i]);
      for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
          const auto cell =
              static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
          if (counting)
            ++first_[cell + 1];
          else
            triangles_[static_cast<std::size_t>(fill[cell]++)] = static_cast<int>(i);
        }
    }
    if (!counting) continue;
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    triangles_.resize(static_cast<std::size_t>(first_.back()));
  }
}

void PatchMap::look(int column, int row, const Vector2d& uv, Hit& hit) const {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  const auto cell =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  for (int k = first_[cell]; k < first_[cell + 1] && !(hit.triangle >= 0 && hit.off <= 0); ++k) {
    const int i = triangles_[static_cast<std::size_t>(k)];
    const Triangle& t = patch_.triangles[static_cast<std::size_t>(i)];
    const Vector2d &a = patch_.uv[static_cast<std::size_t>(t[0])],
                   &b = patch_.uv[static_cast<std::size_t>(t[1])],
                   &c = patch_.uv[static_cast<std::size_t>(t[2])];
    const double twice = cross(b - a, c - a);
    if (!(std::abs(twice) > 1e-12)) continue;
    const Eigen::Vector3d weights(cross(b - uv, c - uv) / twice, cross(c - uv, a - uv) / twice,
                                  cross(a - uv, b - uv) / twice);
    // How far outside each side, by the height of the corner opposite.
    const Eigen::Vector3d sides((c - b).norm(), (a - c).norm(), (b - a).norm());
    double off = 0;
    for (int s = 0; s < 3; ++s) off = std::max(off, -weights[s] * std::abs(twice) / sides[s]);
    if (hit.triangle >= 0 && hit.off <= off) continue;
    hit = {i, off, weights};
  }
}

std::optional<Vector2d> PatchMap::rest_at(const Vector2d& uv, double beyond_mm) const {
  if (columns_ == 0 || !uv.allFinite()) return std::nullopt;
  const Vector2d at = (uv - low_) / cell_;
  if (at.minCoeff() < -1e6 || at.maxCoeff() > 1e6) return std::nullopt;
  const int column = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(at.y()));
  Hit hit;
  look(std::clamp(column, 0, columns_ - 1), std::clamp(row, 0, rows_ - 1), uv, hit);
  if (hit.triangle < 0 || hit.off > 0) {
    const int around = 1 + static_cast<int>(std::min(beyond_mm / cell_, 50.0));
    for (int y = row - around; y <= row + around; ++y)
      for (int x = column - around; x <= column + around; ++x) look(x, y, uv, hit);
  }
  if (hit.triangle < 0 || hit.off > beyond_mm) return std::nullopt;
  const Triangle& t = patch_.triangles[static_cast<std::size_t>(hit.triangle)];
  Vector2d rest(0, 0);
  for (std::size_t k = 0; k < 3; ++k)
    rest += hit.weights[static_cast<Eigen::Index>(k)] * patch_.rest[static_cast<std::size_t>(t[k])];
  if (!rest.allFinite()) return std::nullopt;
  return rest;
}

// What was cut along the outline has the very same points: polygons lie on one grid (worker/pattern/area.cpp).
bool PatchMap::is_border_vertex(const Vector2d& uv) const {
  return std::binary_search(border_.begin(), border_.end(), std::pair(uv.x(), uv.y()));
}

bool PatchMap::covers(const Vector2d& low, const Vector2d& high) const {
  const AlignedBox2d box(low, high);
  for (const Ring& ring : outline_)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      AlignedBox2d side(ring[i]);
      side.extend(ring[(i + 1) % ring.size()]);
      if (side.intersects(box)) return false;
    }
  return rest_at(low).has_value();
}

}  // namespace vacuform
