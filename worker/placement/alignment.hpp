// How the drawing is laid on the chart: turned, scaled and shifted, never bent.
#pragma once

#include <Eigen/Geometry>

#include "worker/placement/charted_surface.hpp"

namespace vacuform {

// chart = turn (scale pattern) + shift, all in mm.
struct Alignment {
  double turn_deg = 0;             // of the drawing, counter-clockwise
  double scale = 1;                // size on the chart relative to the drawing
  Eigen::Vector2d shift_mm{0, 0};  // the drawing's centre, chart coordinates

  Eigen::Vector2d pattern(const Eigen::Vector2d& chart) const;
  Eigen::Vector2d chart(const Eigen::Vector2d& pattern) const;
  Eigen::Affine2d to_pattern() const;  // pattern() for inner loops
};

// Uses only offset_mm, rotate_deg and scale: the centre of the drawing is offset_mm from the top of the mold.
Alignment plain_alignment(const PatternSettings& settings);

// Uses settings.points, offset_mm, rotate_deg and scale. Without points this is the plain alignment. A point of the
// mold means the nearest point of the inked surface of the chart. One point shifts the drawing onto it. With two points
// the first matches exactly and the second lies in its direction. Three or more are matched by rigid least squares.
// Then the drawing is rotated by rotate_deg about the centre of the points on the mold (the first of two), and shifted
// by offset_mm. Errors: bad_settings, naming the row: a point more than 20 mm off the surface of the chart, or points
// that define no direction.
Result<Alignment> align(const ChartedSurface& charted, const PatternSettings& settings);

}  // namespace vacuform
