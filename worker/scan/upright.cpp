#include "worker/scan/upright.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "worker/scan/placing.hpp"

namespace vacuform {

Eigen::Matrix3d turn_before_front(const ScanSettings& settings, UpAxis up) {
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  if (settings.mirror == Mirror::yes) mirror(0, 0) = -1;
  return upright_turn(UpAxis::plus_z, settings.roll_deg, settings.pitch_deg, 0) * mirror *
         upright_turn(up, 0, 0, 0);
}

std::optional<FrontSide> front_of_gltf(const ScanSettings& settings, UpAxis up) {
  const Eigen::Vector3d front = turn_before_front(settings, up).col(2);
  const double x = std::abs(front.x()), y = std::abs(front.y());
  if (std::max(x, y) == 0 || std::abs(front.z()) > std::hypot(x, y)) return std::nullopt;
  if (x > y) return front.x() > 0 ? FrontSide::plus_x : FrontSide::minus_x;
  return front.y() > 0 ? FrontSide::plus_y : FrontSide::minus_y;
}

Eigen::Matrix3d scan_turn(const ScanSettings& settings, UpAxis up) {
  Eigen::Matrix3d front = Eigen::Matrix3d::Identity();
  switch (settings.front) {
    case FrontSide::plus_x:
      front << 0, -1, 0, 1, 0, 0, 0, 0, 1;
      break;
    case FrontSide::minus_x:
      front << 0, 1, 0, -1, 0, 0, 0, 0, 1;
      break;
    case FrontSide::minus_y:
      front << -1, 0, 0, 0, -1, 0, 0, 0, 1;
      break;
    case FrontSide::plus_y:
    case FrontSide::automatic:
      break;
  }
  return upright_turn(UpAxis::plus_z, 0, 0, settings.yaw_deg) * front * turn_before_front(settings, up);
}

Eigen::Matrix3d upright_turn(UpAxis up, double roll_deg, double pitch_deg, double yaw_deg) {
  constexpr double radian = std::numbers::pi / 180;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  switch (up) {  // exact quarter turns, so that a scan that stands upright is not touched
    case UpAxis::plus_y:
      turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      break;
    case UpAxis::minus_y:
      turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      break;
    case UpAxis::plus_x:
      turn << 0, 0, -1, 0, 1, 0, 1, 0, 0;
      break;
    case UpAxis::minus_x:
      turn << 0, 0, 1, 0, 1, 0, -1, 0, 0;
      break;
    case UpAxis::minus_z:
      turn << 1, 0, 0, 0, -1, 0, 0, 0, -1;
      break;
    case UpAxis::plus_z:
    case UpAxis::automatic:
      break;
  }
  const auto about = [&](double degrees, const Eigen::Vector3d& axis) -> Eigen::Matrix3d {
    if (degrees == 0) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(degrees * radian, axis).toRotationMatrix();
  };
  return turn_about_z(yaw_deg * radian) * about(pitch_deg, Eigen::Vector3d::UnitY()) *
         about(roll_deg, Eigen::Vector3d::UnitX()) * turn;
}

}  // namespace vacuform
