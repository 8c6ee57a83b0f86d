// Ink of an element without what lies within some intervals of its loop.
#pragma once

#include <vector>

#include "worker/conductors/gaps.hpp"

namespace vacuform {

// The ink of the loop there: as wide as the trace and half as much again.
Area band(const LoopPath& path, const std::vector<Interval>& intervals);

// What the shapes paint outside of the area. Lines stay lines and end square to themselves there; dashed lines become
// their outlines. Shapes that do not reach into the area stay as they are.
std::vector<Shape> interrupted(const std::vector<Shape>& shapes, const Area& removed);

// A line along a part of the loop that ends square, in black. `width_mm` is in the drawing.
Shape along_loop(const LoopPath& path, const Interval& part, double width_mm);

}  // namespace vacuform
