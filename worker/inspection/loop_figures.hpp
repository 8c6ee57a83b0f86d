// A closed line of the flat sheet, measured on the formed sheet. Internal to worker/inspection.
//
// The figures are those of the inked surface. The centre of a loop is found, not assumed: it is the point of the
// surface from which the geodesic radius of the loop varies least (least squares over the loop by its formed length).
// Anyone who has only the print and the formed sheet finds the same values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/placement/charted_surface.hpp"
#include "worker/surface/exact_geodesics.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// Measures lines on one formed sheet; keeps a reference to its inputs. May be used by several threads at once.
class MeasuredSheet {
 public:
  explicit MeasuredSheet(const ChartedSurface& charted)
      : charted_(charted), locator_(surface().triangles(), surface().rest()) {}

  std::optional<SheetPoint> find(const Eigen::Vector2d& rest) const { return locator_.find(rest); }
  Eigen::Vector3d place(const SheetPoint& at) const { return surface().place(at); }
  bool on_chart(const SheetPoint& at) const { return charted_.on_chart(at.triangle); }
  const InkedSurface& surface() const { return charted_.surface(); }

  // Paths over the surface for one thread; the pointer returns them. They are made for the whole sheet, but each use
  // costs only what is within reach, so returned ones are used again.
  struct GiveBack {
    const MeasuredSheet* sheet;
    void operator()(Geodesics* paths) const { sheet->take_back(paths); }
  };
  std::unique_ptr<Geodesics, GiveBack> paths() const;

 private:
  const ChartedSurface& charted_;
  PlaneLocator locator_;

  void take_back(Geodesics* paths) const;
  mutable std::mutex mutex_;
  mutable std::size_t made_ = 0;
  mutable std::vector<std::unique_ptr<Geodesics>> idle_;  // with room for all that are made
};

struct LoopFigures {
  bool on_head = false;                  // all of it lies on the chart
  Eigen::Vector3d centre{0, 0, 0};       // on the inked surface, mm
  Eigen::Vector2d centre_rest{0, 0};     // sheet coordinates, mm
  double diameter_mm = 0;                // twice the mean geodesic radius
  double circularity = 0;                // largest |r - mean r| / mean r
  double area_mm2 = 0;                   // enclosed, on the surface
  double worst_stretch = 1;              // formed length / flat length of the worst millimetre
  std::vector<Eigen::Vector3d> outline;  // on the inked surface, mm, closed
  // In the plane: directions and distances from its centre along the surface, mm, unchanged or corrected to the true
  // area (shape_distance.hpp).
  std::vector<Eigen::Vector2d> shape;
};

// `line` is a closed polyline in sheet coordinates, the last point joined to the first; `near` is a point near its
// centre. Its shape is true to area, or leaves the distances from the centre unchanged, as `keep` says (coils.keep).
// Returns nothing if a part of it is off the sheet, or if no path joins its centre to it. Lengths and areas are exact
// on the triangles of the sheet; the centre is accurate to 0.01 mm. Deterministic.
std::optional<LoopFigures> measure_loop(const MeasuredSheet& sheet, const std::vector<Eigen::Vector2d>& line,
                                        const Eigen::Vector2d& near, CoilKeep keep = CoilKeep::area);

// The same figures for a loop in the plane: circularity and diameter from its least squares centre.
struct PlaneLoopFigures {
  Eigen::Vector2d centre{0, 0};
  double diameter_mm = 0, circularity = 0, area_mm2 = 0;
};
PlaneLoopFigures measure_plane_loop(const std::vector<Eigen::Vector2d>& line);

// Length of the shortest path over the surface, mm; NaN if there is no path.
double geodesic_distance(const MeasuredSheet& sheet, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

// The line with additional points, so that no piece is longer than `step_mm`. `closed`: the piece from the last point
// to the first counts, and the last point is not repeated.
std::vector<Eigen::Vector2d> densified(const std::vector<Eigen::Vector2d>& line, double step_mm, bool closed);

}  // namespace vacuform
