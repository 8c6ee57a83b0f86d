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

std::optional<FrontSide> side_of(const ScanSettings& settings, UpAxis up, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d turned = turn_before_front(settings, up) * direction;
  const double x = std::abs(turned.x()), y = std::abs(turned.y());
  if (std::max(x, y) == 0 || std::abs(turned.z()) > std::hypot(x, y)) return std::nullopt;
  if (x > y) return turned.x() > 0 ? FrontSide::plus_x : FrontSide::minus_x;
  return turned.y() > 0 ? FrontSide::plus_y : FrontSide::minus_y;
}

PatientAxes axes_of(PatientSpace space) {
  const double left = space == PatientSpace::lps ? 1 : -1;
  return {{left, 0, 0}, {0, -left, 0}, {0, 0, 1}};
}

std::optional<Warning> contradicted_space(PatientSpace space, const ScanSettings& settings, UpAxis up) {
  if (space == PatientSpace::unknown) return std::nullopt;
  constexpr double least = 0.64;  // the cosine of 50 degrees
  const PatientAxes file = axes_of(space);
  const Eigen::Matrix3d turn = scan_turn(settings, up);
  const Eigen::Vector3d left = turn * file.left, front = turn * file.front, head = turn * file.head;
  std::string wrong;
  const auto add = [&](const char* what, bool is_right) {
    if (!is_right) wrong.append(wrong.empty() ? "" : " and ").append(what);
  };
  add("the crown up", head.z() >= least);
  add("the face at +y", front.y() >= least);
  add("the patient's left at -x", left.x() <= -least);
  if (wrong.empty()) return std::nullopt;
  Warning warning{"space-contradicted", "The file says SPACE=" + std::string(name(space)) +
                                            ", but the settings do not bring " + wrong};
  warning.place = "the whole scan";
  return warning;
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
