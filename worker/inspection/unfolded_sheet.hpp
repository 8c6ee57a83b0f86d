// The formed sheet with its pattern coordinates, as files of meshes need it. Internal to worker/inspection.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// The corners of the formed sheet with pattern coordinates. A vertex where several charts meet appears once for each of
// its coordinates: the first has its own number, the others follow after all vertices.
struct Unfolded {
  std::vector<int> vertex;          // of the sheet
  std::vector<Eigen::Vector2d> uv;  // NaN off the charts
  std::vector<Triangle> corners;    // of all triangles of the sheet
};
// By the charts alone, as the figures of the report are.
Unfolded unfolded(const Finished& job);
// With the drawing as a texture. Where coils were placed, the coordinates are exact at their centres and nearly so around
// them: what moved them from the chart is added, and fades beyond their loops.
Unfolded textured(const Finished& job);

}  // namespace vacuform
