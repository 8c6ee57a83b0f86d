// The rigid motion that lays measured points onto where they should be.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace vacuform {

// The rotation and translation with the least weighted sum of squared distances between `to` and the moved `from`
// (Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta Cryst. A 32, 1976). Never a
// reflection. Weights are not negative and not all 0.
Eigen::Isometry3d rigid_motion(const std::vector<Eigen::Vector3d>& from,
                               const std::vector<Eigen::Vector3d>& to, const std::vector<double>& weights);

}  // namespace vacuform
