// The pieces of which a painted drawing consists.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// A fill or a line with ink. A line that runs back on itself fills nothing.
bool has_filled(const Shape& s);
bool has_stroked(const Shape& s);

Eigen::AlignedBox2d box_of_shape(const Shape& shape);

// The curves of a shape that may be painted one after the other without a change: those of an opaque stroke, and the
// parts of a fill that do not lie in each other.
std::vector<Shape> pieces_of(Shape shape);

// What a shape covers with ink.
double ink_mm2(const Shape& shape);

}  // namespace vacuform
