#include "worker/printing/patch_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

std::vector<Ring> border_in_pattern(const Patch& patch) {
  std::vector<Ring> rings;
  for (const auto& vertices : border_loops(patch.triangles)) {
    rings.emplace_back();
    for (const int v : vertices) rings.back().push_back(patch.uv[v]);
  }
  return rings;
}

}  // namespace

PatchMap::PatchMap(const Patch& patch)
    : patch_(patch), locator_(patch.triangles, patch.uv), outline_(union_of(border_in_pattern(patch))) {
  for (const Ring& ring : outline_)
    for (const Vector2d& p : ring) border_.emplace_back(p.x(), p.y());
  std::sort(border_.begin(), border_.end());
}

std::optional<Vector2d> PatchMap::rest_at(const Vector2d& uv, double beyond_mm) const {
  const auto found = locator_.nearest(uv, beyond_mm);
  if (!found) return std::nullopt;
  const Vector2d rest = interpolate(patch_.triangles, *found, patch_.rest);
  if (!rest.allFinite()) return std::nullopt;
  return rest;
}

// Areas that were cut along the outline have exactly its points: polygons lie on one grid (worker/pattern/area.cpp).
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
