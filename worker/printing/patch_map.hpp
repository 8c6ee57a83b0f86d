// From pattern coordinates to sheet coordinates on a patch. Internal to worker/printing.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "worker/pattern/area.hpp"
#include "worker/placement/patch.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// Keeps a reference to its patch.
class PatchMap {
 public:
  explicit PatchMap(const Patch& patch);

  // The place of `uv` on the flat sheet; nothing if it is off the patch by more than `beyond_mm`. Up to that distance
  // the map of the nearest triangle is extended. Where the patch is folded, the first triangle in order is used.
  std::optional<Eigen::Vector2d> rest_at(const Eigen::Vector2d& uv, double beyond_mm = 1e-3) const;

  // The area of the patch in pattern coordinates.
  const Area& outline() const { return outline_; }
  bool is_border_vertex(const Eigen::Vector2d& uv) const;
  // Whether all of the box is inside: then nothing in it needs to be cut.
  bool covers(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;

 private:
  const Patch& patch_;
  PlaneLocator locator_;
  Area outline_;
  std::vector<std::pair<double, double>> border_;  // the outline's points, ascending
};

}  // namespace vacuform
