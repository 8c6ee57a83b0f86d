// What polygons cover together, and what they share. Internal to worker/pattern.
#pragma once

#include <vector>

#include "worker/pattern/area.hpp"

namespace vacuform {

enum class FillRule { non_zero, even_odd };

// What the rings cover by the rule. Exact to 1e-5 mm in position; points within 0.0005 mm of a straight line
// are left out. Deterministic. Polygons of up to 10,000 points go to the clipping library at once. Larger
// ones are cut into vertical strips first, which moves points by 1e-5 mm at most.
Area covered_by(const std::vector<Ring>& rings, FillRule rule);

// What both cover, each by the non-zero rule.
Area shared_by(const std::vector<Ring>& a, const std::vector<Ring>& b);

// What `a` covers and `b` does not, each by the non-zero rule.
Area remainder_of(const std::vector<Ring>& a, const std::vector<Ring>& b);

// The parts of an open line outside of what the rings cover, by the non-zero rule; in no order.
std::vector<std::vector<Eigen::Vector2d>> line_outside(const std::vector<Eigen::Vector2d>& line,
                                                       const std::vector<Ring>& rings);

}  // namespace vacuform
