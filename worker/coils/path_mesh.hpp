// A surface made ready for exact_geodesics.hpp: each triangle laid flat from each of its sides, and who is beyond.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/scan/triangle_mesh.hpp"

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

  // Whether a shortest path may bend at the vertex: where its angles add up to more than a full turn, and on the border.
  bool bends_at(int vertex) const { return bends_[static_cast<std::size_t>(vertex)] != 0; }
  // The sides opposite a vertex.
  std::vector<int> around(int vertex) const;

 private:
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<Side> sides_;
  std::vector<char> bends_;
  std::vector<int> first_, around_;  // of vertex v: around_[first_[v]] up to around_[first_[v + 1]]
};

}  // namespace vacuform
