// The plane in which a body is nearly its own mirror image: the median plane of a head.
#pragma once

#include <vector>

#include "worker/scan/mold_distance.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Mirrors a body in planes through the centroid of its surface.
class MirrorTest {
 public:
  explicit MirrorTest(const TriangleMesh& body);  // keeps a reference

  // How far the mirror image lies off the body: the mean distance of about 120 points, as a share of its diagonal. 0 if
  // the body is symmetric. `normal`: of the plane, one unit long. Only every `stride`-th point is used.
  double error(const Eigen::Vector3d& normal, std::size_t stride = 1) const;

  struct Plane {
    Eigen::Vector3d normal;
    double error;
  };
  // The best of all planes, to half a degree: of 200 even directions, the six best apart, refined. About 25,000 distances.
  Result<Plane> best(const ScanProgress& progress) const;  // errors: cancelled
  // The best of the planes that contain a direction, to a degree.
  Result<Plane> best_along(const Eigen::Vector3d& direction, const ScanProgress& progress) const;

 private:
  Result<Plane> refined(Plane plane, const ScanProgress& progress) const;

  MoldDistance distance_;
  std::vector<Eigen::Vector3d> points_;  // from the centroid
  Eigen::Vector3d centroid_ = Eigen::Vector3d::Zero();
  double size_;
};

}  // namespace vacuform
