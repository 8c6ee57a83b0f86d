// The loop that a coil is drawn as: a closed line, a line with gaps for its capacitors and its feed, or a filled ring.
//
// Recognised alike in the drawing and in its print. Deterministic.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/pattern/area.hpp"

namespace vacuform {

// The middle of a stroke as points, mm; of a closed one the last point is not the first again.
struct LoopLine {
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
  double width_mm = 0;
};

struct DrawnLoop {
  enum class Kind { closed_line, gapped_line, filled_ring };
  Kind kind = Kind::closed_line;
  std::vector<Eigen::Vector2d> line;  // closed; the last point is not the first again
  double width_mm = 0;
  double area_mm2 = 0;    // enclosed by the line
  std::size_t lines = 1;  // that it is made of
};

// The closed line of the largest area.
std::optional<DrawnLoop> closed_line(const std::vector<LoopLine>& lines);

// Open lines in a row, closed by straight pieces across their gaps: at most 15 % of the way round is gap, what is drawn
// turns by more than 300 degrees about the loop's middle and the whole by 360, and the loop has at least a quarter of the
// area of a circle of its length, which a zigzag or a pair of leads has not. Lines shorter than all that the loop is made
// of, such as leads, may be left over. Of more than 32 open lines the longest 32 are looked at.
std::optional<DrawnLoop> gapped_line(const std::vector<LoopLine>& lines);

// The middle between the largest outline and the largest one inside it, where the radius of the circle that has the inner
// one's area is more than half of the outer one's, and no width is less than half of the mean or more than twice it. Not of outlines of more than 2048 points.
std::optional<DrawnLoop> filled_ring(const Area& outlines);

// The largest of these in an element, in pattern coordinates; a ring is one where a shape has a fill and no stroke.
std::optional<DrawnLoop> drawn_loop(const Element& element);

// Points of a curve within 0.002 mm of it.
LoopLine loop_line(const Curve& curve, double width_mm);

// Above zero where counter-clockwise.
double signed_area(const std::vector<Eigen::Vector2d>& line);

}  // namespace vacuform
