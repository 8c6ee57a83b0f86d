// How the drawing is laid on the chart: turned, scaled and shifted, never bent.
#pragma once

#include "worker/placement/charted_surface.hpp"

namespace vacuform {

// chart = turn (scale pattern) + shift, all in mm.
struct Alignment {
  double turn_deg = 0;             // of the drawing, counter-clockwise
  double scale = 1;                // size on the chart against the drawing
  Eigen::Vector2d shift_mm{0, 0};  // the drawing's centre, chart coordinates

  Eigen::Vector2d pattern(const Eigen::Vector2d& chart) const;
  Eigen::Vector2d chart(const Eigen::Vector2d& pattern) const;
};

// By offset_mm, rotate_deg and scale alone: the drawing's centre lies offset_mm from the top of the mold.
Alignment plain_alignment(const PatternSettings& settings);

// By settings.points, offset_mm, rotate_deg and scale. Without points it is the plain one. A point of the mold means the
// nearest one of the chart's inked surface. One point shifts the drawing onto it; of two the first meets and the second lies in its direction; three and more are met by rigid least squares. Then the
// drawing is turned by rotate_deg about the middle of the mold's points (the first of two), and shifted by offset_mm.
// Errors: bad_settings, naming the row: a point more than 20 mm off the chart's surface, or points that give no direction.
Result<Alignment> align(const ChartedSurface& charted, const PatternSettings& settings);

}  // namespace vacuform
