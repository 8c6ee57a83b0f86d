// Painted areas as polygons: strokes with their caps, joins and dashes, fills by their rule, and what areas share.
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

// Of the line where it is drawn widest.
double widest_mm(const Stroke& stroke);

// What a stroke along `curves` covers, as SVG draws it, within `tolerance_mm` but for the corners of dashes.
Area stroke_area(const std::vector<Curve>& curves, const Stroke& stroke, double tolerance_mm);

Area intersection(const Area& a, const Area& b);
// Of rings in any order and sense: what any of them winds around.
Area union_of(const std::vector<Ring>& rings);

double square_mm(const Area& area);

}  // namespace vacuform
