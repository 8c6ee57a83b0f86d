// Exact shortest paths over the triangles of a surface (S.-Q. Xin and G.-J. Wang, "Improving Chen and Han's algorithm on
// the discrete geodesic problem", 2009, by CGAL).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "worker/forming/sheet_map.hpp"

namespace vacuform {

class Geodesics {
 public:
  // Over the triangles `which` of a surface, by their own numbers everywhere; the paths keep to them. About 10 ms and
  // 1 MB for 1,000 triangles and a source.
  Geodesics(const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& surface,
            const std::vector<int>& which);
  ~Geodesics();

  // Where the next paths begin. False where that is on none of the triangles.
  bool begin_at(const SheetPoint& source);

  struct Path {
    double length;          // mm
    Eigen::Vector3d start;  // unit vector in which it leaves the source; 0 where it has no length
  };
  // Nothing where the target is on none of the triangles, or not connected to the source by them.
  std::optional<Path> to(const SheetPoint& target) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The triangles of `triangles` that a path from a to b of at most `length` mm over the surface may touch: those near the
// ellipsoid about both; with a = b those near a ball of half that length. Ascending.
std::vector<int> within_reach(const std::vector<Triangle>& triangles,
                              const std::vector<Eigen::Vector3d>& surface, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b, double length);

}  // namespace vacuform
