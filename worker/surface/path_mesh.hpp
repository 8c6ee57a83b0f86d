// A surface prepared for exact_geodesics.hpp: each triangle laid flat from each of its sides, and its neighbours.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// What the paths need of a surface; may be read by several threads at once. Made in one pass and a sort of the
// sides. Sides are numbered 3 * triangle + k, k the corner opposite; a side runs from corner k + 1 to corner k + 2.
class PathMesh {
 public:
  // Triangles that all have the same orientation. Where more than two meet in an edge, paths end there.
  PathMesh(std::vector<Triangle> triangles, std::vector<Eigen::Vector3d> places);

  struct Side {
    int opposite = -1;  // the same side as the neighbour numbers it; -1 at the border
    double length = 0;  // mm
    double foot = 0,
           height = 0;  // of the corner opposite, along the side from its beginning and across it, mm
  };
  const Side& side(int s) const { return sides_[s]; }
  int corner(int triangle, int k) const { return triangles_[triangle][k % 3]; }
  const Eigen::Vector3d& place(int vertex) const { return places_[vertex]; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<Eigen::Vector3d>& places() const { return places_; }

  // The sum of the angles around a vertex, radians; infinite on the border.
  double total_angle(int vertex) const { return total_angles_[vertex]; }
  // Whether that is more than a full turn: a shortest path may bend at such a vertex, and leaves at least half a turn
  // on either side of it.
  bool is_saddle(int vertex) const;
  // The angle in the corner opposite a side, radians.
  double angle(int s) const;
  // A triangle at a vertex is named by the side opposite the vertex. Returns the next one around the vertex,
  // counter-clockwise as the triangles are, or clockwise; -1 beyond the border.
  int next_around(int s, bool counter_clockwise) const;

 private:
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<Side> sides_;
  std::vector<double> total_angles_;
};

}  // namespace vacuform
