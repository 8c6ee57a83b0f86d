// Where the coils of a drawing are.
#pragma once

#include <string>
#include <vector>

#include "worker/pattern/pattern.hpp"

namespace vacuform {

struct CoilCentre {
  std::string id;      // of the drawing, or "coil-1", "mark-1", ... (worker/pattern/sorting.hpp)
  Eigen::Vector2d uv;  // pattern coordinates, mm from the drawing's centre, v up
};

// The elements of a vector drawing, or of a picture. Deterministic.
std::vector<CoilCentre> coil_centres(const Pattern& pattern);

}  // namespace vacuform
