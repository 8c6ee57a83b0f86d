// The trace of a loop as it lies on the part.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/conductors/loop_path.hpp"
#include "worker/placement/patch.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// Keeps a reference to the patch.
class Trace {
 public:
  // `scale`: millimetres on the part for one in the drawing, along the loop.
  Trace(const DrawnLoop& loop, const Patch& patch, double width_mm, double scale);

  const LoopPath& path() const { return path_; }
  double width_mm() const { return width_mm_; }  // on the part
  double scale() const { return scale_; }

  // In space, a length along the loop in the drawing and so far to the left of its middle, mm on the part. Nothing off the
  // patch.
  std::optional<Eigen::Vector3d> at(double along, double left_mm = 0) const;

  // The same place on the flat sheet, mm.
  std::optional<Eigen::Vector2d> rest(double along, double left_mm = 0) const;

  // How far the trace must be followed to both sides of where it crosses another, until all of it is farther than
  // `beyond_mm` from the other's edges: mm in the drawing, in steps of .05 mm on the part; a quarter of the loop at most.
  double clear_of(double along, const Trace& other, double along_other, double beyond_mm) const;

 private:
  std::optional<SheetPoint> find(double along, double left_mm) const;

  LoopPath path_;
  const Patch& patch_;
  PlaneLocator locator_;
  double width_mm_, scale_;
};

}  // namespace vacuform
