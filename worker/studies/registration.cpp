#include "worker/studies/registration.hpp"

#include <Eigen/SVD>

namespace vacuform {

Eigen::Isometry3d rigid_motion(const std::vector<Eigen::Vector3d>& from,
                               const std::vector<Eigen::Vector3d>& to, const std::vector<double>& weights) {
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = from_mean;
  double whole = 0;
  for (std::size_t i = 0; i < from.size(); ++i)
    from_mean += weights[i] * from[i], to_mean += weights[i] * to[i], whole += weights[i];
  from_mean /= whole, to_mean /= whole;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += weights[i] * (to[i] - to_mean) * (from[i] - from_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = svd.matrixU() * turn * svd.matrixV().transpose();
  motion.translation() = to_mean - motion.linear() * from_mean;
  return motion;
}

}  // namespace vacuform
