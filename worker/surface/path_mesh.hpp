// A surface made ready for exact_geodesics.hpp: each triangle laid flat from each of its sides, and who is beyond.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A copy of what the paths need of a surface; may be read by several threads at once. Made in one pass and a sort of the
// sides. Sides are numbered 3 * triangle + k, k the corner opposite; a side runs from corner k + 1 to corner k + 2.
class PathMesh {
 public:
  // Triangles that all turn the same way; where more than two meet in an edge, paths end there.
  PathMesh(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& places);

  struct Side {
    int beyond = -1;    // the same side as the neighbour numbers it; -1 at the border
    double length = 0;  // mm
    double foot = 0,
           height = 0;  // of the corner opposite, along the side from its beginning and across it, mm
  };
  const Side& side(int s) const { return sides_[static_cast<std::size_t>(s)]; }
  int corner(int triangle, int k) const {
    return triangles_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k % 3)];
  }
  const Eigen::Vector3d& place(int vertex) const { return places_[static_cast<std::size_t>(vertex)]; }
  int triangles() const { return static_cast<int>(triangles_.size()); }
  int vertices() const { return static_cast<int>(places_.size()); }

  // The angles around a vertex, radians; infinite on the border. A shortest path may bend at a vertex where they are more than
  // a full turn, and leaves at least half a turn on either side of it.
  double turn(int vertex) const { return turns_[static_cast<std::size_t>(vertex)]; }
  bool bends_at(int vertex) const;
  // The angle in the corner opposite a side, radians.
  double angle(int s) const;
  // A triangle at a vertex is named by the side opposite. The next around the vertex, counter-clockwise as the triangles
  // are, or the other way round; -1 beyond the border.
  int next_around(int s, bool counter_clockwise) const;

 private:
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<Side> sides_;
  std::vector<double> turns_;
};

}  // namespace vacuform
