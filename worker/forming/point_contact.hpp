// Contact of the mold's sharp places with the sheet's triangles.
#pragma once

#include <optional>
#include <vector>

#include "worker/forming/mold_points.hpp"
#include "worker/forming/process.hpp"

namespace vacuform {

class PointContact {
 public:
  explicit PointContact(const Process& process);

  // Looks for points of the mold that come through the sheet as it moves straight from state.x to y, after
  // SheetState::follow(). Each takes the nearest vertex of its triangle that has not been taken before, moves it in
  // state.rest to the point of the sheet that meets it, in state.x to where that was, and in y to the point of the mold,
  // and holds it. Returns the triangles whose rest shape changed, ascending. Deterministic.
  std::vector<int> follow(const Process& process, SheetState& state, Points& y, double from_time,
                          double to_time);

 private:
  struct Crossing {
    double time;  // of the way, in [0, 1]
    int triangle, point;
    Eigen::Vector3d weights;  // of the triangle's corners
  };
  std::optional<Crossing> crossing(const Process& process, const Points& x, const Points& y, int triangle,
                                   int point) const;
  // The vertex that the crossing takes, or -1.
  int vertex_for(const Process& process, const SheetState& state, const Points& y,
                 const Crossing& crossing) const;

  // Whether a neighbour of the vertex was taken by a place close to the point.
  bool is_crowded(const Process& process, const Points& y, int vertex, int point) const;

  MoldPoints points_;
  std::vector<char> caught_;           // of the points
  std::vector<char> taken_;            // of the vertices
  std::vector<int> start_, triangle_;  // around each vertex
  double tolerance_mm_;                // a point that stands less above the sheet is not through it
  double apart_mm_;                    // vertices that are held nearer to each other are crowded
  double seen_mm_;                     // one that stands more above it already is on its other side
  double least_area_;                  // of a triangle on the flat sheet
};

}  // namespace vacuform
