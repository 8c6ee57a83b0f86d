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

// Of an SVG, the middles of the boxes around its groups with an id (around its shapes with an id where they are in no
// such group; layers and groups of groups are looked into), in the order of the file. Of any other drawing, or where
// there is no id, the centroids of the connected parts of its ink that are larger than 1 mm2, by rows from the top.
// `bytes` are those that `pattern` was read from. Deterministic.
std::vector<CoilCentre> coil_centres(std::span<const std::uint8_t> bytes, const Pattern& pattern);

}  // namespace vacuform
