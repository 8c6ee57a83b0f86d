// Painted areas as polygons: strokes with their caps, joins and dashes, fills by their rule, unions and intersections.
//
// Polygons are exact to 1e-5 mm in position. Deterministic.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// Closed; the last point is joined to the first.
using Ring = std::vector<Eigen::Vector2d>;

// Rings that do not cross: counter-clockwise around what is inside, clockwise around holes.
using Area = std::vector<Ring>;

// What a shape's fill covers. Chords lie within `tolerance_mm` of the curves.
Area fill_area(const std::vector<Curve>& curves, bool even_odd, double tolerance_mm);

// The width of the line where it is widest.
double widest_mm(const Stroke& stroke);

// What a stroke along `curves` covers, as SVG draws it, within `tolerance_mm` except for the corners of dashes.
Area stroke_area(const std::vector<Curve>& curves, const Stroke& stroke, double tolerance_mm);

Area intersection(const Area& a, const Area& b);
Area difference(const Area& a, const Area& b);
// What any of the rings winds around; they may have any order and direction.
Area union_of(const std::vector<Ring>& rings);

double square_mm(const Area& area);

}  // namespace vacuform
