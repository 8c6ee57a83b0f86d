// The inked surface with the chart that the flattening maps a part of it to.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "worker/flattening/flattening.hpp"
#include "worker/surface/inked_surface.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// Keeps references to both: they must outlive it.
class ChartedSurface {
 public:
  ChartedSurface(const InkedSurface& surface, const Flattening& flattening);

  const InkedSurface& surface() const { return *surface_; }
  const Flattening& flattening() const { return *flattening_; }
  bool on_chart(int t) const { return on_chart_[t] != 0; }
  std::vector<Eigen::Vector3d> border() const;       // the middles of the chart's outer edges, in space
  Eigen::Vector2d chart(const SheetPoint& p) const;  // chart coordinates, mm; NaN off the chart

  // The point with the given chart coordinates. Off the chart, the nearest point of its border. If the chart overlaps
  // itself, the point that is nearest in space to `near`, or without it that of the first triangle. Linear in the
  // triangles of the chart with `near`, and off the chart in the edges of its border.
  struct OnChart {
    SheetPoint point{};
    double off_mm = 0;  // distance from the chart, chart millimetres; 0 on it
  };
  OnChart at_chart(const Eigen::Vector2d& chart, const std::optional<Eigen::Vector3d>& near = {}) const;

  // The direction in the plane of triangle t of the chart that is the u axis of the chart, by the rotation nearest to
  // the map of the flattening there. Off the chart the s axis of the sheet is used instead of u.
  Eigen::Vector3d axis(int t) const;

 private:
  // Of the points with these chart coordinates the one that is nearest to `near`.
  std::optional<SheetPoint> nearest_of(const Eigen::Vector2d& chart, const Eigen::Vector3d& near) const;

  const InkedSurface* surface_;
  const Flattening* flattening_;
  std::vector<char> on_chart_;
  PlaneLocator locator_;  // on the chart
  std::vector<std::pair<int, int>>
      border_;  // triangles, and which of their edges have nothing of the chart across
};

}  // namespace vacuform
