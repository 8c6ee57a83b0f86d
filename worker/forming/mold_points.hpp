// The places of the mold that can come through a triangle of the sheet between its vertices: ridges, rims, tips, fins.
//
// Contact of the sheet's vertices with the mold's faces sees nothing that is thinner than the grid. So the mold's own
// convex vertices, and points along its convex edges, are followed as well: where one of them comes through a triangle,
// the triangle's nearest vertex is moved to it, in the flat sheet and in space, and held there. The mesh then bends where the
// mold does. (Moving the mesh to a feature: r-adaptivity, Huang and Russell, "Adaptive Moving Mesh Methods", 2011.)
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

class MoldPoints {
 public:
  // Of all convex vertices and edges, those off which the mold falls by at least `drop_mm` within half a grid spacing;
  // points along edges lie at most a quarter of a spacing apart.
  MoldPoints(const TriangleMesh& mold, double spacing_mm, double drop_mm);

  std::size_t size() const { return places_.size(); }
  const Eigen::Vector3d& place(int point) const { return places_[point]; }
  // Whether three or more sharp edges meet there, or one ends.
  bool is_corner(int point) const { return corner_[point] != 0; }

  // Calls visit(point) for every point in a box, and some beside it, in ascending order within each cell.
  template <class Visit>
  void in_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, Visit&& visit) const {
    if (places_.empty() || (high.array() < low_.array()).any() || (low.array() > high_.array()).any()) return;
    const Eigen::Vector3i first = cell(low), last = cell(high);
    for (int z = first.z(); z <= last.z(); ++z)
      for (int y = first.y(); y <= last.y(); ++y) {
        const std::size_t row = (static_cast<std::size_t>(z) * static_cast<std::size_t>(count_.y()) +
                                 static_cast<std::size_t>(y)) *
                                static_cast<std::size_t>(count_.x());
        for (int k = start_[row + static_cast<std::size_t>(first.x())];
             k < start_[row + static_cast<std::size_t>(last.x()) + 1]; ++k)
          visit(k);
      }
  }

 private:
  Eigen::Vector3i cell(const Eigen::Vector3d& at) const;

  std::vector<Eigen::Vector3d> places_;  // sorted by cell
  std::vector<char> corner_;
  std::vector<int> start_;  // of each cell's points
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero(), high_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i count_ = Eigen::Vector3i::Ones();
  double size_ = 1;
};

}  // namespace vacuform
