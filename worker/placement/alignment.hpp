// How the drawing is laid on the chart: turned, scaled and shifted, never bent.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/placement/charted_surface.hpp"

namespace vacuform {

// chart = turn (scale pattern) + shift, all in mm.
struct Alignment {
  double turn_deg = 0;             // of the drawing, counter-clockwise
  double scale = 1;                // size on the chart relative to the drawing
  Eigen::Vector2d shift_mm{0, 0};  // the drawing's centre, chart coordinates
  // The place of the point about which it was turned, mm: where a chart overlaps itself, the part near it is meant.
  std::optional<Eigen::Vector3d> centre = {};

  Eigen::Vector2d pattern(const Eigen::Vector2d& chart) const;
  Eigen::Vector2d chart(const Eigen::Vector2d& pattern) const;
  Eigen::Affine2d to_pattern() const;  // pattern() for inner loops
};

// Uses only offset_mm, rotate_deg and scale: the centre of the drawing is at chart coordinates offset_mm.
Alignment plain_alignment(const PatternSettings& settings);

// Uses settings.points, offset_mm, rotate_deg and scale. Without points the centre of the drawing lies on the origin of
// the chart. A point of the mold means the nearest point of the inked surface of the chart. One point shifts the
// drawing onto it. With two points the first matches exactly and the second lies in its direction. Three or more are
// matched by rigid least squares. Then the drawing is rotated by rotate_deg about the centre of the points on the mold
// (the first of two; without points the origin), and that centre is moved by offset_mm along the inked surface: on the
// straightest geodesic that leaves it in that direction of the chart, for the length of the offset. The directions of
// the drawing are carried along in parallel, so rotate_deg still means the directions that the chart has at the
// beginning. If the origin is not on the chart, because pins moved it, offset_mm shifts the drawing in the chart.
// Errors: bad_settings, naming the row: a point more than 20 mm off the surface of the chart, or points that define no
// direction; naming pattern.offset_mm: an offset that leads off the chart.
Result<Alignment> align(const ChartedSurface& charted, const PatternSettings& settings);

// The same with offset_mm as a shift in the plane: how the drawing lies on the flat sheet if it is printed as drawn,
// with the top of the mold (Flattening::top_rest) as the origin.
Result<Alignment> align_flat(const ChartedSurface& charted, const PatternSettings& settings);

}  // namespace vacuform
