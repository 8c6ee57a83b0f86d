// Conductors that are closed, or nearly: lines, lines with gaps for capacitors and a feed, filled rings.
//
// Deterministic.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/pattern/area.hpp"

namespace vacuform {

// The middle of a trace as points, mm; of a closed one the first point is not repeated.
struct LoopLine {
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
  double width_mm = 0;
};

// A closed line that leaves a hole. It may cross itself, like a figure of eight.
std::optional<DrawnLoop> closed_loop(const LoopLine& line);

// Open lines in a row, closed by straight pieces across their gaps.
struct GappedLoop {
  DrawnLoop loop;
  std::vector<std::size_t> lines;  // of those given, ascending
};

// Every end is joined to the one that it leads to: near, and ahead of it. A gap is at most 15 % of the way round, all
// together at most 25 %, and the loop has at least a quarter of the area of a circle of its length, unlike a zigzag or
// a pair of leads. Lines in no loop are left over. O(n log n) for lines whose ends are far apart; at most 4096 lines
// are examined, the longest.
std::vector<GappedLoop> gapped_loops(const std::vector<LoopLine>& lines);

// The middle between the largest outline and the largest one inside it. The radius of a circle with the area of the
// inner one must be more than half of that of the outer one, and every width between half of the mean and twice the
// mean. Of longer outlines 2048 points are examined.
std::optional<DrawnLoop> filled_ring(const Area& outlines);

// The middle of a filled band with two ends, such as a part of a ring. Nothing for areas with holes, for others that
// are not at least five times as long as wide.
std::optional<LoopLine> filled_band(const Area& outlines);

// Points of a curve within 0.002 mm of it.
LoopLine loop_line(const Curve& curve, double width_mm);

// Positive if counter-clockwise.
double signed_area(const std::vector<Eigen::Vector2d>& line);

// Enclosed by a closed line; of one that crosses itself, what is on one side of it an odd number of times.
double lobes_area(const std::vector<Eigen::Vector2d>& line);

bool is_inside(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& ring);

}  // namespace vacuform
