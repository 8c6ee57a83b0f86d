// Where the coils of a drawing are.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "worker/pattern/pattern.hpp"

namespace vacuform {

struct CoilCentre {
  std::string id;      // of the drawing's group; "ink-1", ... where the drawing has none
  Eigen::Vector2d uv;  // pattern coordinates, mm from the drawing's centre, v up
};

// The elements of a vector drawing; for any other drawing, or one without ids, the parts of its ink
// (worker/pattern/ink_parts.hpp). `bytes` are those that `pattern` was read from. Deterministic.
std::vector<CoilCentre> coil_centres(std::span<const std::uint8_t> bytes, const Pattern& pattern);

}  // namespace vacuform
