// The rotation and translation that takes points as near as it can to others, by weighted least squares (Kabsch, "A
// solution for the best rotation to relate two sets of vectors", Acta Cryst. A 32, 1976). Never a reflection.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace vacuform {

// In the plane. Weights are not negative and not all 0.
class RigidFit {
 public:
  void add(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double weight = 1);

  // The weighted means, which the motion takes onto each other.
  Eigen::Vector2d from() const { return from_ / weight_; }
  Eigen::Vector2d to() const { return to_ / weight_; }
  // The length of (cosine, sine) of the rotation before they are normalized: 0 where the points give no direction.
  double direction() const { return turn().norm(); }
  double angle() const;  // of the rotation, radians; 0 without a direction
  Eigen::Isometry2d motion() const;

 private:
  Eigen::Vector2d turn() const;
  struct Pair {
    Eigen::Vector2d from, to;
    double weight;
  };
  std::vector<Pair> pairs_;
  double weight_ = 0;
  Eigen::Vector2d from_{0, 0}, to_{0, 0};
};

// In space: takes `from` onto `to`, which is as long, as `weights` are. Weights are not negative and not all 0.
Eigen::Isometry3d rigid_motion(const std::vector<Eigen::Vector3d>& from,
                               const std::vector<Eigen::Vector3d>& to, const std::vector<double>& weights);

}  // namespace vacuform
