// The loop that a coil is drawn as: a closed line, a line with gaps for its capacitors and its feed, or a filled ring.
//
// Recognised alike in the drawing and in its print. Deterministic.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/pattern/area.hpp"

namespace vacuform {

// The middle of a stroke as points, mm; for a closed one the first point is not repeated.
struct LoopLine {
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
  double width_mm = 0;
};

struct DrawnLoop {
  enum class Kind { closed_line, gapped_line, filled_ring };
  Kind kind = Kind::closed_line;
  std::vector<Eigen::Vector2d> line;  // closed; the first point is not repeated
  double width_mm = 0;
  double area_mm2 = 0;    // enclosed by the line
  std::size_t lines = 1;  // that it is made of
};

// The closed line of the largest area.
std::optional<DrawnLoop> closed_line(const std::vector<LoopLine>& lines);

// Open lines in a row, closed by straight pieces across their gaps. Gaps are at most 15 % of the way round. What is
// drawn turns by more than 300 degrees about the loop's middle and the whole by 360. The loop has at least a quarter of
// the area of a circle of its length, unlike a zigzag or a pair of leads. Lines shorter than all lines of the loop,
// such as leads, may be left over. Only the longest 32 open lines are examined.
std::optional<DrawnLoop> gapped_line(const std::vector<LoopLine>& lines);

// The middle between the largest outline and the largest one inside it. The radius of a circle with the area of the
// inner one must be more than half of that of the outer one, and every width between half of the mean and twice the
// mean. Nothing for outlines of more than 2048 points.
std::optional<DrawnLoop> filled_ring(const Area& outlines);

// The largest of these in an element, in pattern coordinates. Only a shape with a fill and without a stroke can be a
// ring.
std::optional<DrawnLoop> drawn_loop(const Element& element);

// Points of a curve within 0.002 mm of it.
LoopLine loop_line(const Curve& curve, double width_mm);

// Positive if counter-clockwise.
double signed_area(const std::vector<Eigen::Vector2d>& line);

}  // namespace vacuform
