// Undercuts: what the sheet, coming from above, cannot reach. A grid of vertical rays finds the empty space below an
// overhang; adjacent columns whose empty spans meet form one pocket.
//
// The depth at a place is the horizontal distance to the nearest column without an overhang at that height, minus half
// a grid cell; the depth of a pocket is the largest of these. Pits without a roof are not undercuts. Space that is
// walled in on all sides is not either: the inside of a hollow shell that stands on the platform counts as solid.
#pragma once

#include <memory>
#include <vector>

#include "worker/scan/mold.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The columns of a closed, outwards oriented mesh, seen along a given axis.
class CoveredSpace {
 public:
  // Casts the rays, `spacing` mm apart, down onto the mesh as `turn` turns it, which stands on z = floor. The centre of
  // its bounding box lies halfway between rays, so that a mirrored mesh is measured alike. `caster` belongs to the same
  // mesh, unturned: one serves every turn. Heights, places and planes are those of the turned mesh. Cost: columns times
  // surfaces crossed; if the rays would cross more than 2.5 million they are cast further apart. Errors: cancelled;
  // unusable_scan if on average fifty layers lie above each other.
  static Result<CoveredSpace> measure(const TriangleMesh& mesh, std::shared_ptr<const RayCaster> caster,
                                      const Eigen::Matrix3d& turn, double floor, double spacing,
                                      const ScanProgress& progress);
  static Result<CoveredSpace> measure(const TriangleMesh& mesh, double floor, double spacing,
                                      const ScanProgress& progress) {
    return measure(mesh, std::make_shared<RayCaster>(mesh), Eigen::Matrix3d::Identity(), floor, spacing,
                   progress);
  }

  // The pockets above the plane z = floor, as if the mesh were cut there; deepest first (ties: larger area,
  // then order on the grid). Spans lower than two fifths of the spacing are left out.
  std::vector<Undercut> undercuts(double floor) const;

  // The lowest plane above which no undercut is deeper than `depth` and larger than `area` (seen from above), to a
  // fiftieth of the spacing; the floor given to measure() if there is no such undercut. On a sphere of radius R that is
  // sqrt(2 R depth - depth^2) below the equator.
  double lowest_cut(double depth, double area) const;

  // How much of the mesh seen from above is a dome that stands out of z = floor: the share of its columns that are above
  // the floor, as are their neighbours `reach` mm away on either side, along x and along y, and not lower than the mean
  // of these. Columns with a neighbour beside the mesh do not count. 1 for anything convex that stands on its widest
  // section.
  double domed_share(double floor, double reach) const;

 private:
  struct Span {  // empty space under a ceiling
    int column;
    double low, high;
  };
  Eigen::Vector2d place(int column) const;
  double least_height() const { return 0.4 * spacing_; }
  struct Search;
  void build_pyramid();
  void search(Search& s, std::size_t level, int x, int y) const;
  double depth_at(int column, double z, double enough) const;
  std::vector<std::vector<int>> pockets(const std::vector<Span>& spans) const;
  bool reaches_air(const std::vector<Span>& spans, const std::vector<int>& pocket) const;
  std::vector<Span> above(double floor) const;
  bool has_undercut(double floor, double depth, double area) const;

  std::shared_ptr<const RayCaster> caster_;
  Eigen::Matrix3d back_ = Eigen::Matrix3d::Identity();  // from the turned mesh to the caster's
  double floor_ = 0, ceiling_ = 0, spacing_ = 1;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int nx_ = 0, ny_ = 0;
  std::vector<double> top_;  // of each column; -inf where nothing stands
  std::vector<Span> spans_;  // by column, from above
  struct Level {             // lowest top of each block of 2^k x 2^k columns
    int nx, ny;
    std::vector<double> lowest;
  };
  std::vector<Level> pyramid_;  // from k = 1 on
};

// The warning "undercut", with place and depth of the twenty deepest as marks. `undercuts` has at least one, deepest
// first.
Warning undercut_warning(const std::vector<Undercut>& undercuts);

}  // namespace vacuform
