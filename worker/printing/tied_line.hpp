// Lines that join elements: each end lies where its element's patch puts it, the way between follows the chart. Internal
// to worker/printing.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "worker/pattern/curve.hpp"
#include "worker/printing/patch_map.hpp"

namespace vacuform {

// Distance of a point from an area; 0 inside.
double distance(const Eigen::Vector2d& p, const Area& area);

// Keeps references to the maps.
class TiedLine {
 public:
  // `start` and `end` are the maps of the elements that the ends of `line` touch, null where an end is free.
  TiedLine(std::vector<CurvePoint> line, double width_mm, const PatchMap& chart, const PatchMap* start,
           const PatchMap* end);

  // Of a point on the line or beside it. Nothing off the chart.
  std::optional<Eigen::Vector2d> rest_at(const Eigen::Vector2d& uv) const;

 private:
  struct Tie {
    const PatchMap* map = nullptr;
    double reach = 0;  // along the line, mm: there the chart has taken over
  };
  double along(const Eigen::Vector2d& uv) const;  // of the line's nearest point
  Tie tie(const PatchMap* map, bool from_end) const;

  const std::vector<CurvePoint> line_;
  const double beside_;  // how far ink lies beside the line
  const PatchMap& chart_;
  std::array<Tie, 2> ties_;
};

}  // namespace vacuform
