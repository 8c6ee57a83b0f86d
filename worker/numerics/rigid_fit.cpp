#include "worker/numerics/rigid_fit.hpp"

#include <Eigen/SVD>
#include <cmath>

#include "worker/numerics/plane.hpp"

namespace vacuform {

using Eigen::Vector2d;

void RigidFit::add(const Vector2d& from, const Vector2d& to, double weight) {
  pairs_.push_back({from, to, weight});
  weight_ += weight, from_ += weight * from, to_ += weight * to;
}

Vector2d RigidFit::turn() const {
  const Vector2d from = this->from(), to = this->to();
  Vector2d out(0, 0);
  for (const auto& [p, q, w] : pairs_) {
    const Vector2d a = p - from, b = q - to;
    out += Vector2d(w * a.dot(b), w * cross(a, b));
  }
  return out;
}

double RigidFit::angle() const {
  const Vector2d cosine_sine = turn();
  return std::atan2(cosine_sine.y(), cosine_sine.x());
}

Eigen::Isometry2d RigidFit::motion() const {
  Eigen::Isometry2d out = Eigen::Isometry2d::Identity();
  out.rotate(Eigen::Rotation2Dd(angle()));
  out.translation() = to() - out.linear() * from();
  return out;
}

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
